#pragma once

#include <filesystem>

namespace divemesh::bench {

// Returns the time that OpenCV's MODE_SGBM_3WAY (128 disparities, blocks of 5, P1 200, P2 800)
// takes for a pair of the dive on one thread, ms, without decoding. It is the mean over every
// `stride`-th pair.
double sgbm_ms_per_frame(const std::filesystem::path& dive, int stride);

}  // namespace divemesh::bench
