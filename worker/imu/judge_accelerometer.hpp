#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/imu/estimate_alignment.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// A test of the accelerometer by vision alone. Over half a second, with R the orientation by vision
// in the frame of its first image,
//
//     (integral R a dt - (v_end - v_begin)) / dt = -g
//
// is the same vector whatever the rig does. An accelerometer with wrong axes measures a gravity
// that turns with the rig.
class GravityByVision {
public:
    // `samples` must outlive this, on the cameras' clock and in the body frame.
    explicit GravityByVision(const std::vector<types::ImuSample>& samples) : samples_(samples) {}

    void add(const VisionMotion& motion);
    // Returns how far the last half minute's forces are from their median, m/s^2, median; nullopt:
    // fewer than five seconds without a loss of vision, or fewer than three frames a second.
    std::optional<double> disagreement_m_s2() const;

private:
    void start(const VisionMotion& motion);
    void finish_span(const Eigen::Vector3d& velocity, std::int64_t now_ns);

    const std::vector<types::ImuSample>& samples_;
    std::int64_t last_ns_ = 0;
    bool started_ = false;
    Eigen::Quaterniond q_first_body_ = Eigen::Quaterniond::Identity();
    Eigen::Vector3d last_velocity_ = Eigen::Vector3d::Zero();  // m/s, over the last motion
    std::int64_t span_began_ns_ = 0;
    Eigen::Vector3d velocity_at_begin_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d integral_ = Eigen::Vector3d::Zero();  // m/s, of R a
    std::vector<Eigen::Vector3d> forces_;                 // m/s^2, one a span
};

// The accelerometer does not fit if the disagreement is larger. A bias, which turns with the rig,
// and the error of the velocities stay below: good units have 0.02 to 0.05.
constexpr double kMaxGravityDisagreement_m_s2 = 0.25;

}  // namespace divemesh::imu
