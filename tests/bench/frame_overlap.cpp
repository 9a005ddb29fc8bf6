#include "tests/bench/frame_overlap.hpp"

#include <Eigen/Geometry>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "tests/bench/images.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/camera/projection.hpp"
#include "worker/dive/dive.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kGrid_px = 16;  // between the pixels that are asked

std::vector<Eigen::Vector3d> surface_points(const fs::path& depth_file,
                                            const types::Camera& camera) {
    const cv::Mat depth_mm = cv::imread(depth_file.string(), cv::IMREAD_UNCHANGED);
    if (depth_mm.type() != CV_16U) throw std::runtime_error("no depth in " + depth_file.string());
    std::vector<Eigen::Vector3d> points;
    for (int v = kGrid_px / 2; v < depth_mm.rows; v += kGrid_px)
        for (int u = kGrid_px / 2; u < depth_mm.cols; u += kGrid_px)
            if (const auto mm = depth_mm.at<std::uint16_t>(v, u))
                points.emplace_back(0.001 * mm * camera::unproject(camera, Eigen::Vector2d(u, v)));
    return points;
}

}  // namespace

struct FrameOverlap::Frames {
    types::Camera camera;
    std::vector<Eigen::Isometry3d> T_world_cam0;
    std::vector<std::vector<Eigen::Vector3d>> p_cam0;
};

FrameOverlap::FrameOverlap(const fs::path& dive) : frames_(std::make_unique<Frames>()) {
    const TemporaryFolder scratch;
    const auto opened = dive::Dive::open(dive, scratch.path());
    frames_->camera = opened->rig().cam0;
    std::map<std::int64_t, Eigen::Isometry3d> truth;
    for (const auto& pose : opened->ground_truth()) truth[pose.timestamp_ns] = pose.T_world_imu;
    for (const auto& [left, right] : pair_files(dive)) {
        const std::string stamp = left.stem().string();
        frames_->T_world_cam0.push_back(truth.at(std::stoll(stamp)) * opened->rig().T_imu_cam0);
        frames_->p_cam0.push_back(
            surface_points(dive / "truth/cam0/depth" / (stamp + ".png"), frames_->camera));
    }
}

FrameOverlap::~FrameOverlap() = default;

int FrameOverlap::num_frames() const { return static_cast<int>(frames_->p_cam0.size()); }

double FrameOverlap::between(int a, int b) const {
    const auto& points = frames_->p_cam0[static_cast<std::size_t>(a)];
    const Eigen::Isometry3d T_b_a = frames_->T_world_cam0[static_cast<std::size_t>(b)].inverse() *
                                    frames_->T_world_cam0[static_cast<std::size_t>(a)];
    std::size_t num_inside = 0;
    for (const Eigen::Vector3d& p_a : points) {
        const auto pixel = camera::project(frames_->camera, T_b_a * p_a);
        if (pixel && camera::contains(frames_->camera, *pixel)) ++num_inside;
    }
    return points.empty() ? 0.0
                          : static_cast<double>(num_inside) / static_cast<double>(points.size());
}

std::vector<int> FrameOverlap::spaced_by(double overlap) const {
    std::vector<int> kept = {0};
    for (int i = 1; i + 1 < num_frames(); ++i)
        if (between(kept.back(), i + 1) < overlap) kept.push_back(i);
    return kept;
}

}  // namespace divemesh::bench
