#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/types/rig.hpp"

namespace divemesh::types {

struct ImuSample {
    std::int64_t timestamp_ns = 0;
    Eigen::Vector3d angular_velocity_imu = Eigen::Vector3d::Zero();  // rad/s
    Eigen::Vector3d acceleration_imu = Eigen::Vector3d::Zero();      // m/s^2, specific force
};

struct OrientationSample {
    std::int64_t timestamp_ns = 0;
    Eigen::Quaterniond q_world_imu = Eigen::Quaterniond::Identity();
};

struct PressureSample {
    std::int64_t timestamp_ns = 0;
    double depth_m = 0.0;  // positive down
};

// One synchronised stereo pair as recorded, distorted; 8 bit, grey.
struct StereoFrame {
    int index = 0;  // in the list of matched pairs; skipped frames leave a gap
    std::int64_t timestamp_ns = 0;
    cv::Mat left;
    cv::Mat right;
};

struct StampedPose {
    std::int64_t timestamp_ns = 0;
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
};
using Trajectory = std::vector<StampedPose>;  // stamps strictly rising

// What the reconstruction sees of a dive, wherever it comes from. Frames come in order, one at a
// time; a second pass starts again with rewind().
class Recording {
public:
    virtual ~Recording() = default;

    virtual const Rig& rig() const = 0;
    virtual int num_frames() const = 0;  // matched pairs, the undecodable ones included
    virtual const std::vector<ImuSample>& imu() const = 0;           // rising; empty: none
    virtual const std::vector<OrientationSample>& ahrs() const = 0;  // rising; empty: none
    virtual const std::vector<PressureSample>& pressure() const = 0;

    // The next pair that decodes; nothing at the end. What does not decode is skipped, counted and
    // kept as a finding. One thread at a time.
    virtual std::optional<StereoFrame> next_frame() = 0;
    // The left picture of a frame that next_frame() gave, 8 bit BGR; grey dives: three equal
    // channels. Decoded when asked for: most frames are never looked at in colour. Any thread.
    virtual cv::Mat left_in_color(int frame_index) const = 0;
    virtual void rewind() = 0;
    virtual std::int64_t num_skipped_frames() const = 0;
};

}  // namespace divemesh::types
