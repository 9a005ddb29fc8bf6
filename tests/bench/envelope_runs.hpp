#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/envelope_plan.hpp"
#include "tests/bench/kept_results.hpp"

namespace divemesh::bench {

// One dive of the envelope: axis, step, scene and seed.
struct EnvelopeRun {
    const EnvelopeAxis& axis;
    const EnvelopeStep& step;
    std::string scene;
    int seed = 0;

    std::string name() const;
};

// Renders, changes, reconstructs and measures dives of the envelope. Keeps rendered dives and
// results of SIFT in `cache`, and results in `results` as long as the program is the same.
class EnvelopeRuns {
public:
    EnvelopeRuns(std::filesystem::path program,
                 std::filesystem::path cache,
                 const std::filesystem::path& results,
                 EnvelopeScale scale);

    // Returns the run that envelope_judge.hpp describes. With the baseline its entry `sift` holds
    // linked_share, ate_m and scale of SIFT and PnP. Throws std::runtime_error if the dive cannot
    // be rendered.
    nlohmann::json measured(const EnvelopeRun& run);

private:
    std::filesystem::path rendered(const EnvelopeRun& run,
                                   double length_m,
                                   const std::vector<std::string>& words) const;
    DiveSources sources_of(const EnvelopeRun& run) const;
    std::string size() const;  // a part of the names of results
    nlohmann::json measure(const EnvelopeRun& run);
    nlohmann::json reconstructed(const EnvelopeRun& run,
                                 const std::filesystem::path& dive,
                                 const std::filesystem::path& out) const;
    nlohmann::json sift(const EnvelopeRun& run, const std::filesystem::path& dive);

    std::filesystem::path program_;
    std::filesystem::path cache_;
    KeptResults kept_;
    KeptResults kept_sift_;
    EnvelopeScale scale_;
};

}  // namespace divemesh::bench
