#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace divemesh::bench {

// The dense matcher beside OpenCV's semi-global modes on the Middlebury pairs of the shared data
// (Scharstein and Szeliski): share of the pixels with a known, unoccluded truth whose disparity is
// missing or off by more than 2 px, range 128, the first 128 columns left out. As a run of
// the dive `middlebury`: per pair, and as `figures` the mean over the pairs of ours, of OpenCV's
// best mode, and the ratio of both. Of each of OpenCV's modes the better of block sizes 3 and 5,
// with its checks (uniqueness 5 %, left-right) and without. Nothing where the pairs are absent.
nlohmann::json compare_on_stereo_pairs(const std::filesystem::path& middlebury);

// The same for every condition of the images and each pair by itself: ours, OpenCV's best, and
// bad-2.0 of the answered beside MODE_SGBM with its checks (uniqueness 10 %) at the same density,
// the less dense of both; of ours the pixels with the smallest sigmas.
nlohmann::json compare_under_conditions(const std::filesystem::path& middlebury);

}  // namespace divemesh::bench
