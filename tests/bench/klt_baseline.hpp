#pragma once

#include <filesystem>

namespace divemesh::bench {

// CPU time per frame, in ms, of what no visual odometry can do without, by OpenCV: both pictures
// decoded, goodFeaturesToTrack(300) and calcOpticalFlowPyrLK from the frame before and back.
double klt_cpu_ms_per_frame(const std::filesystem::path& dive);

}  // namespace divemesh::bench
