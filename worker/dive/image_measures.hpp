#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::dive {

// Physical measures of one grey image: 8 bit as recorded, or reduced_to_640_px() where stated. None
// depends on brightness or contrast, except texture.

// Returns the image as CV_32F, reduced to 640 px of width if it is wider. Sharpness, darkness and
// texture measure this, and take either: what several of them measure is reduced once.
cv::Mat reduced_to_640_px(const cv::Mat& image);

// Returns the energy of fine detail (2 px) relative to coarse detail (8 px): what a lens out of
// focus or a fogged port loses first. 0 for an image of one colour.
double sharpness(const cv::Mat& image);

// Returns how much lines differ from their neighbours, relative to lines two apart, over the same
// of columns. It is 1 for an image taken at once and grows where two fields show two times.
// Measured in the middle, at most 640 px wide and high.
double combing(const cv::Mat& image);

// Returns how much the four pixels of a 2 x 2 cell differ everywhere in the same way, relative to
// the mean brightness: 0, or the differences of the colours in a Bayer mosaic. Measured in the
// middle, at most 640 px wide and high.
double mosaic_contrast(const cv::Mat& image);

// Returns true if almost the whole image is dark. False for images too small to decide.
bool is_dark(const cv::Mat& image);

// Returns true if at least half of the image, without its black parts, has texture above its noise:
// a median contrast of details of about 4 px, in images reduced to 640 px of width. False for a
// dark image, true for images too small to decide.
bool has_texture(const cv::Mat& image);

}  // namespace divemesh::dive
