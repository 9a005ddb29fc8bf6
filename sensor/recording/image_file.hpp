#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>

namespace divemesh::sensor {

// Reads an image as the camera writes it, CV_8UC1 or BGR as recorded. It is empty while the file is
// incomplete, if it is not an image, and if it is too large (64 MiB, 64 million pixels).
cv::Mat read_image(const std::filesystem::path& file);

}  // namespace divemesh::sensor
