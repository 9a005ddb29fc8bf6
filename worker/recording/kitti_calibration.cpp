#include "worker/recording/kitti_calibration.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "schemas/trimmed.hpp"
#include "worker/dive/csv.hpp"

namespace divemesh::recording {
namespace {

constexpr std::size_t kMaxNumbers = 12;  // of a projection, the longest line

// Returns the numbers of the line that begins with a key, a camera's number and a colon; empty if
// there is no such line or one of them is no number.
std::vector<double> numbers_of(std::string_view text,
                               std::string_view key,
                               const std::string& camera) {
    std::string start(key);
    start.append(camera).append(":");
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = trimmed(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        if (!line.starts_with(start)) continue;
        line = trimmed(line.substr(start.size()));
        std::vector<double> numbers;
        while (!line.empty() && numbers.size() <= kMaxNumbers) {
            const std::size_t blank = std::min(line.find(' '), line.size());
            const auto number = dive::parse_double(line.substr(0, blank));
            if (!number || !std::isfinite(*number)) return {};
            numbers.push_back(*number);
            line = trimmed(line.substr(blank));
        }
        return numbers;
    }
    return {};
}

template <std::size_t kSize>
bool take(const std::vector<double>& numbers, std::array<double, kSize>& values) {
    if (numbers.size() != kSize) return false;
    std::copy(numbers.begin(), numbers.end(), values.begin());
    return true;
}

bool is_size(const std::vector<double>& numbers, ImageSize size) {
    return numbers.size() == 2 && numbers[0] == static_cast<double>(size.width_px) &&
           numbers[1] == static_cast<double>(size.height_px);
}

CameraInfo info_of_size(ImageSize size) {
    CameraInfo info;
    info.width_px = static_cast<std::uint32_t>(size.width_px);
    info.height_px = static_cast<std::uint32_t>(size.height_px);
    return info;
}

// Rectified images have no lens model: the camera matrix is that of the projection.
void use_projection(CameraInfo& info) {
    const auto& p = info.projection;
    info.camera_matrix = {p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]};
}

std::optional<CameraInfo> odometry_camera(std::string_view text, int camera, ImageSize size) {
    CameraInfo info = info_of_size(size);
    if (!take(numbers_of(text, "P", std::to_string(camera)), info.projection)) return std::nullopt;
    use_projection(info);
    return info;
}

std::optional<CameraInfo> raw_camera(std::string_view text, int camera, ImageSize size) {
    const std::string number = (camera < 10 ? "_0" : "_") + std::to_string(camera);
    CameraInfo info = info_of_size(size);
    const bool has_all = take(numbers_of(text, "P_rect", number), info.projection) &&
                         take(numbers_of(text, "R_rect", number), info.rectification) &&
                         take(numbers_of(text, "K", number), info.camera_matrix);
    if (!has_all) return std::nullopt;
    if (is_size(numbers_of(text, "S_rect", number), size)) {
        use_projection(info);
        return info;
    }
    info.distortion_model = "plumb_bob";
    info.distortion_coefficients = numbers_of(text, "D", number);
    const bool is_raw = is_size(numbers_of(text, "S", number), size);
    return is_raw && info.distortion_coefficients.size() == 5 ? std::optional(info) : std::nullopt;
}

std::optional<CameraInfo> camera_of(std::string_view text, int camera, ImageSize size) {
    const auto odometry = odometry_camera(text, camera, size);
    return odometry ? odometry : raw_camera(text, camera, size);
}

// Returns where the projection puts the rectified frame's origin in the camera, m.
Eigen::Vector3d origin_of(const CameraInfo& info) {
    const Eigen::Matrix<double, 3, 4> P =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(info.projection.data());
    return P.leftCols<3>().inverse() * P.col(3);
}

void put(const Eigen::Matrix3d& R_aligned_rect, CameraInfo& info) {
    using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    Eigen::Map<Rows> R_rect_cam(info.rectification.data());
    if (R_rect_cam.isZero()) R_rect_cam.setIdentity();
    const Rows aligned = R_aligned_rect * R_rect_cam;
    R_rect_cam = aligned;
    info.projection[3] = info.projection[7] = info.projection[11] = 0.0;
}

// Turns the rectified frame of both cameras so that the baseline is along x, as ROS has it.
bool align(CameraInfos& infos) {
    const Eigen::Vector3d baseline = origin_of(infos.left) - origin_of(infos.right);
    if (!baseline.allFinite() || baseline.norm() == 0.0) return false;
    const Eigen::Matrix3d R_aligned_rect =
        Eigen::Quaterniond::FromTwoVectors(baseline, Eigen::Vector3d::UnitX()).toRotationMatrix();
    put(R_aligned_rect, infos.left);
    put(R_aligned_rect, infos.right);
    infos.right.projection[3] = -baseline.norm() * infos.right.projection[0];
    return true;
}

}  // namespace

std::optional<CameraInfos> kitti_cameras(std::string_view text,
                                         int left,
                                         int right,
                                         ImageSize size) {
    auto left_info = camera_of(text, left, size);
    auto right_info = camera_of(text, right, size);
    if (!left_info || !right_info) return std::nullopt;
    CameraInfos infos{std::move(*left_info), std::move(*right_info)};
    return align(infos) ? std::optional(std::move(infos)) : std::nullopt;
}

}  // namespace divemesh::recording
