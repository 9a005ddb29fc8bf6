#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace divemesh::sensor {

// A picture as the camera writes it, CV_8UC1 or BGR as it was recorded; empty as long as it is not
// there whole, and when it is none. What is too large (64 MiB, 64 million pixels) is none.
cv::Mat read_image(const std::filesystem::path& file);

}  // namespace divemesh::sensor
