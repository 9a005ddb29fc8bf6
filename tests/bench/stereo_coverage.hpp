#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace divemesh::bench {

struct CoverageOptions {
    int num_pairs = 6;             // spread over the dive
    int num_disparities_px = 128;  // of both matchers
    std::filesystem::path images;  // folder for disparity images; "": writes none
};

// Matches pairs of a dive, rectified by the rig aligned to its images, with our matcher and with
// OpenCV's MODE_SGBM_3WAY (blocks of 5, uniqueness 10 %, left-right check, speckles of 100 px
// removed). Returns the share of the image that gets a disparity, without the columns that OpenCV
// leaves out, for each pair and as means, and the CPU time of both on one thread.
nlohmann::json compare_coverage(const std::filesystem::path& dive, const CoverageOptions& options);

}  // namespace divemesh::bench
