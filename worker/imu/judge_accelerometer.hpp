#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/wrong_times.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// A test of the accelerometer by vision alone. With R the orientation and p the position by vision
// in the frame of the first image, and the lead u(t) = (double integral of R a) - p(t),
//
//     d^2 u / dt^2 = -g
//
// is the same vector whatever the rig does. It is the second difference of u over two seconds:
// positions so far apart measure it at any frame rate, whereas velocities from one frame to
// the next have a noise that grows with the rate. An accelerometer with wrong axes measures a
// gravity that rotates with the rig.
class GravityByVision {
public:
    // `samples` must outlive this, on the cameras' clock and in the body frame.
    explicit GravityByVision(const std::vector<types::ImuSample>& samples) : samples_(samples) {}

    void add(const VisionMotion& motion);
    // Returns how far the last half minute's forces are from those two seconds earlier, m/s^2,
    // median: orientations by vision drift over longer times, the more so the more frames they are
    // chained of. Times that wrong_times() finds are left out. nullopt: fewer than six seconds
    // without a loss of vision, or fewer than three frames a second.
    std::optional<double> disagreement_m_s2() const;
    // Returns the times in which the forces differ from those before and after.
    std::vector<types::TimeInterval> wrong_times() const;

private:
    struct Mark {
        std::int64_t time_ns = 0;
        Eigen::Vector3d lead = Eigen::Vector3d::Zero();
    };

    void start(std::int64_t time_ns);
    void finish_span();

    const std::vector<types::ImuSample>& samples_;
    std::int64_t last_ns_ = 0;
    Eigen::Quaterniond q_first_body_ = Eigen::Quaterniond::Identity();
    Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // m/s, the integral of R a
    Eigen::Vector3d lead_ = Eigen::Vector3d::Zero();      // m
    std::vector<Mark> marks_;  // the ends of the last spans; empty: none has begun
    // The forces, m/s^2, one a span: of every time without a loss of vision.
    std::vector<std::vector<Difference>> runs_;
};

// The accelerometer does not fit if the disagreement is larger. A bias, which rotates with the rig,
// and the error of the velocities stay below: good units have 0.02 to 0.05.
constexpr double kMaxGravityDisagreement_m_s2 = 0.35;

}  // namespace divemesh::imu
