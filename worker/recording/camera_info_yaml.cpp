#include "worker/recording/camera_info_yaml.hpp"

#include <algorithm>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/dive/yaml_document.hpp"

namespace divemesh::recording {
namespace {

constexpr double kMaxSize_px = 65535.0;

std::uint32_t size_at(const YAML::Node& root, const char* key, const std::string& file) {
    const double size_px = dive::number_at(root, key).value_or(0.0);
    if (!(size_px >= 1.0 && size_px <= kMaxSize_px) || size_px != std::floor(size_px))
        throw Error(ErrorCode::BadData,
                    file + ": " + key + " is no size of an image: calibrate the camera again");
    return static_cast<std::uint32_t>(size_px);
}

// Reads a matrix of N numbers; it stays 0 where the key is missing.
template <std::size_t N>
void read_matrix(const YAML::Node& root,
                 const char* key,
                 const std::string& file,
                 std::array<double, N>& matrix) {
    const auto numbers = dive::numbers_at(root, key);
    if (numbers.empty()) return;
    if (numbers.size() != N)
        throw Error(ErrorCode::BadData,
                    file + ": " + key + " has " + std::to_string(numbers.size()) +
                        " numbers instead of " + std::to_string(N) +
                        ": calibrate the camera again");
    std::copy(numbers.begin(), numbers.end(), matrix.begin());
}

}  // namespace

CameraInfo read_camera_info_yaml(const YAML::Node& root, const std::string& file) {
    CameraInfo info;
    info.frame = file;
    info.width_px = size_at(root, "image_width", file);
    info.height_px = size_at(root, "image_height", file);
    info.distortion_model = dive::text_at(root, "distortion_model");
    if (info.distortion_model.empty()) info.distortion_model = "plumb_bob";  // as its parser does
    info.distortion_coefficients = dive::numbers_at(root, "distortion_coefficients");
    read_matrix(root, "camera_matrix", file, info.camera_matrix);
    read_matrix(root, "rectification_matrix", file, info.rectification);
    read_matrix(root, "projection_matrix", file, info.projection);
    return info;
}

}  // namespace divemesh::recording
