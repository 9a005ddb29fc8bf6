#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/envelope_plan.hpp"
#include "tests/bench/kept_results.hpp"

namespace divemesh::bench {

// One dive of the envelope: where it is, and on which step.
struct EnvelopeRun {
    const EnvelopeAxis& axis;
    const EnvelopeStep& step;
    std::string scene;
    int seed = 0;

    std::string name() const;
};

// Renders, changes, reconstructs and measures dives of the envelope. Rendered dives and what SIFT
// makes of them are kept in `cache`, results in `results` as long as the program is the same.
class EnvelopeRuns {
public:
    EnvelopeRuns(std::filesystem::path program,
                 std::filesystem::path cache,
                 const std::filesystem::path& results,
                 EnvelopeScale scale);

    // Returns what envelope_judge.hpp describes, and of SIFT and PnP, if asked, as `sift`:
    // linked_share, ate_m, scale. Throws std::runtime_error if the dive cannot be rendered.
    nlohmann::json measured(const EnvelopeRun& run);

private:
    std::filesystem::path rendered(const EnvelopeRun& run,
                                   double length_m,
                                   const std::vector<std::string>& words) const;
    DiveSources sources_of(const EnvelopeRun& run) const;
    std::string size() const;  // in the names of results
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
