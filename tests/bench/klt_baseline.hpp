#pragma once

#include <filesystem>

namespace divemesh::bench {

// Returns the CPU time per frame, ms, of the minimum work of a visual odometry, with OpenCV:
// decoding both images, goodFeaturesToTrack(300), and calcOpticalFlowPyrLK from the previous frame
// and back.
double klt_cpu_ms_per_frame(const std::filesystem::path& dive);

}  // namespace divemesh::bench
