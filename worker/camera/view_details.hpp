#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::camera {

// Returns an image (8 bit grey) reduced to 160 px of width, as CV_32F; a narrower one in its size.
cv::Mat small_view(const cv::Mat& image);

// Returns the details of an image, by its small_view(): without what is coarser than about 3 px.
cv::Mat view_details(const cv::Mat& small_view);

// Returns whether two images, by their view_details() of one size, are of one view: the scene did
// not move from one to the other, even if light or fish did. It compares cells of the images in
// place by zero-shift NCC: most of those with texture are alike. True for images without texture.
bool is_same_view(const cv::Mat& first_details, const cv::Mat& second_details);

}  // namespace divemesh::camera
