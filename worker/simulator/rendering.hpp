#pragma once

#include <opencv2/core/mat.hpp>

namespace divemesh::simulator {

// One image before the sensor: linear light, and the ground truth of what it shows.
struct Rendering {
    cv::Mat radiance;  // CV_32FC3, r g b
    cv::Mat depth;     // CV_32F, m along the optical axis, of the scene without fish; 0: no surface
    cv::Mat albedo;    // CV_32FC3, reflectance of the scene without fish
    cv::Mat fish;      // CV_8U, 255 where any part of a pixel sees a fish
    cv::Mat snow;      // CV_8U, 255 where snow covers more than a twentieth
};

}  // namespace divemesh::simulator
