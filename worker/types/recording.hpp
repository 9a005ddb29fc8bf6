#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/types/rig.hpp"

namespace divemesh::types {

// One sample of gyroscope and accelerometer, in the imu frame.
struct ImuSample {
    std::int64_t timestamp_ns = 0;
    Eigen::Vector3d angular_velocity_imu = Eigen::Vector3d::Zero();  // rad/s
    Eigen::Vector3d acceleration_imu = Eigen::Vector3d::Zero();      // m/s^2, specific force
};

// One orientation from the AHRS, in the AHRS's world (z up).
struct OrientationSample {
    std::int64_t timestamp_ns = 0;
    Eigen::Quaterniond q_world_imu = Eigen::Quaterniond::Identity();
};

// One depth from the pressure sensor.
struct PressureSample {
    std::int64_t timestamp_ns = 0;
    double depth_m = 0.0;  // positive down
};

// One synchronised stereo pair as recorded (not undistorted), 8 bit grey.
struct StereoFrame {
    int index = 0;  // in the list of matched pairs; skipped frames leave gaps
    std::int64_t timestamp_ns = 0;
    cv::Mat left;
    cv::Mat right;
    double right_delay_s = 0.0;  // of the right image's exposure; negative: before the left one's
};

// The pose of the body at a time.
struct StampedPose {
    std::int64_t timestamp_ns = 0;
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
};
using Trajectory = std::vector<StampedPose>;  // timestamps strictly ascending

// A dive as the reconstruction reads it, independent of the file format. Frames come in order, one
// at a time; rewind() starts a second pass.
class Recording {
public:
    virtual ~Recording() = default;

    virtual const Rig& rig() const = 0;
    virtual int num_frames() const = 0;  // matched pairs, including those that do not decode
    virtual const std::vector<ImuSample>& imu() const = 0;           // ascending; empty: no IMU
    virtual const std::vector<OrientationSample>& ahrs() const = 0;  // ascending; empty: no AHRS
    virtual const std::vector<PressureSample>& pressure() const = 0;
    // Returns a mask (CV_8UC1, as recorded): 255 where left images show something that stays in
    // place while the scene moves, such as text, a part of the rig or the border of a round image.
    // Empty: no such pixels.
    virtual const cv::Mat& fixed_pattern() const = 0;

    // Returns the next pair that decodes; nullopt at the end. Frames that do not decode are
    // skipped, counted and reported as a finding. Not thread-safe.
    virtual std::optional<StereoFrame> next_frame() = 0;
    // Returns the pair of an index, whatever next_frame() returned; nullopt if it does not decode.
    // Thread-safe.
    virtual std::optional<StereoFrame> frame(int index) const = 0;
    // Returns the left image of a frame that next_frame() returned, 8 bit BGR; of a grey dive with
    // three equal channels. It is decoded on demand, as most frames are never needed in colour.
    // With a `reduction` of 2, 4 or 8 it has that part of its size, rounded down, which takes less
    // time; 1: all of it. Thread-safe.
    virtual cv::Mat left_in_color(int frame_index, int reduction) const = 0;
    virtual void rewind() = 0;
    virtual std::int64_t num_skipped_frames() const = 0;
};

}  // namespace divemesh::types
