#pragma once

#include <filesystem>

namespace divemesh::bench {

// Milliseconds that OpenCV's MODE_SGBM_3WAY (128 disparities, blocks of 5, P1 200, P2 800) takes
// for a pair of the dive on one thread, pictures decoded beforehand: mean over every `stride`-th.
double sgbm_ms_per_frame(const std::filesystem::path& dive, int stride);

}  // namespace divemesh::bench
