#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/simulator/jet.hpp"
#include "worker/simulator/path_time.hpp"
#include "worker/simulator/stretch.hpp"

namespace divemesh::simulator {

// The path of a diver in a scene and the viewing direction of the rig: an ellipse about
// `center_world`, or a straight line from there along x. The body's x axis points along the path
// (rotated by `look_yaw`), y to the left, z up, tilted down by `look_pitch`.
struct SurveyPath {
    Eigen::Vector3d center_world = Eigen::Vector3d::Zero();  // z: height of the rig
    bool straight = false;  // else an ellipse, described by the next three and `max_scale`
    double semi_axis_x_m = 3.0;
    double semi_axis_y_m = 1.3;
    double start_angle = 0.0;
    double look_yaw = 0.0;
    double look_pitch = 0.6;
    double speed_m_s = 0.25;
    double max_scale = 1.5;    // how much a closed lap may be enlarged
    double sway = 1.0;         // times a diver's
    double swing_rad_s = 0.0;  // highest rate of a swing of 20 degrees in yaw to both sides
};

// Pose, velocity (m/s), acceleration (m/s^2, without gravity) and rate of rotation (rad/s) of the
// body.
struct MotionState {
    Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
    Eigen::Vector3d velocity_world = Eigen::Vector3d::Zero();
    Eigen::Vector3d acceleration_world = Eigen::Vector3d::Zero();
    Eigen::Vector3d angular_velocity_imu = Eigen::Vector3d::Zero();
};

// The exact motion of the body: the survey path plus a diver's sway as sums of sines, smooth at all
// times, with analytic derivatives. A closed lap is periodic in all quantities.
class DiverMotion {
public:
    // Returns an open path of `length_m` from t = 0. If it is longer than the ellipse, it continues
    // on a second lap beside its own track.
    static DiverMotion open_path(const SurveyPath& path, double length_m, std::uint64_t seed);
    // Returns a closed lap of `length_m` that takes a whole number of frames. Throws
    // Error{InvalidArgument} if the scene is too small for it or its path is straight.
    static DiverMotion closed_lap(const SurveyPath& path,
                                  double length_m,
                                  double rate_hz,
                                  std::uint64_t seed);

    // Returns the same open path with rests, each at a share of the path.
    DiverMotion with_pauses(const std::vector<Stretch>& pauses) const;

    MotionState at(double t_s) const;
    double duration_s() const;  // of the open path, or of one lap

private:
    struct Sway {
        double amplitude;
        double frequency_hz;
        double phase;
    };
    using Sways = std::vector<Sway>;
    struct Way {  // a state of the path without sway
        Jet x;    // from the centre, m
        Jet y;
        Jet yaw;  // rad
    };

    DiverMotion(const SurveyPath& path, std::uint64_t seed);
    double length_m(double path_duration_s) const;  // without rests
    void close(double lap_s);
    Way line_at(const Jet& t) const;
    Way ellipse_at(const Jet& t) const;
    Jet sum(const Sways& sways, const Jet& t) const;

    SurveyPath path_;
    double angle_rate_ = 0.0;       // rad/s round the ellipse
    double widening_ = 0.0;         // of the ellipse per radian; 0 when closed
    double path_duration_s_ = 0.0;  // without rests
    PathTime path_time_;
    std::array<Sways, 6> sways_;  // x y z (m), yaw pitch roll (rad)
};

}  // namespace divemesh::simulator
