#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace divemesh::bench {

struct CoverageOptions {
    int num_pairs = 6;               // spread over the dive
    int num_disparities_px = 128;    // of both matchers
    std::filesystem::path pictures;  // "": none are written
};

// Matches pairs of a dive, rectified by the rig that its images tell, with ours and with OpenCV's
// MODE_SGBM_3WAY (blocks of 5, uniqueness 10 %, left-right, speckles of 100 px removed), in turns.
// Returns the share of the image that gets a disparity, beyond the columns that OpenCV leaves out,
// per pair and as means, and the processor time of both on one thread.
nlohmann::json compare_coverage(const std::filesystem::path& dive, const CoverageOptions& options);

}  // namespace divemesh::bench
