#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::io {

// The image of a keyframe and its pose; z forward, x right, y down.
struct PosedImage {
    std::string name;            // 000012.jpg
    std::filesystem::path file;  // the small image in keyframes/
    int frame_index = 0;
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
};

// Returns the whole rectified left image of a keyframe, CV_8UC3 BGR, by the index of its frame.
using WholeImage = std::function<cv::Mat(int frame_index)>;

// The images of the keyframes with the pinhole camera of them all. Pixels count from the corner of
// the image, as in COLMAP and nerfstudio: the centre of the first one is at (0.5, 0.5), where our
// own files have (0, 0).
struct PosedImages {
    int width_px = 0;
    int height_px = 0;
    double focal_px = 0.0;
    Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
    std::vector<PosedImage> images;  // in the order of time
    WholeImage whole;                // empty: they are the small images in keyframes/
};

// Reads keyframes.json and the sizes of the images in keyframes/, for `whole` images without the
// latter. Throws Error{NotFound} that names a missing file, Error{BadData} for a file that is
// broken, an image of another size, or a frame that is named twice.
PosedImages read_posed_images(const ReconstructionFolder& reconstruction,
                              const WholeImage& whole = {});

// Returns the bytes of an image. Throws Error{NotFound} if it cannot be read.
std::string read_image_bytes(const std::filesystem::path& file);

// Writes the images into a folder: small ones as they are, whole ones as JPEG of quality 95. Throws
// as AtomicFile does.
void write_images(const PosedImages& images, const std::filesystem::path& folder);

}  // namespace divemesh::io
