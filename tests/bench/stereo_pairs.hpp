#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace divemesh::bench {

// Compares the dense matcher with OpenCV's semi-global modes on the Middlebury pairs of the shared
// data (Scharstein and Szeliski). The error is the share of the pixels with a known, unoccluded
// truth whose disparity is missing or off by more than 2 px, with 128 disparities and without the
// first 128 columns. Returns a run of the dive `middlebury`: our error for each pair, and as
// `metrics` the mean of ours, of OpenCV's best mode, and their ratio. Each mode of OpenCV runs with
// its checks (uniqueness 5 %, left-right) and without, and with the better of block sizes 3 and 5.
// Returns null without the pairs.
nlohmann::json compare_on_stereo_pairs(const std::filesystem::path& middlebury);

// Returns the same comparison for each pair under each condition of the images. It adds the share
// of disparities off by more than 2 px, ours and that of MODE_SGBM with checks (uniqueness 10 %
// or more), at the same density: the lower of the two. Of ours the pixels with the smallest sigmas
// count.
nlohmann::json compare_under_conditions(const std::filesystem::path& middlebury);

}  // namespace divemesh::bench
