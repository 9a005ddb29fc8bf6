#include "worker/simulator/diver_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "schemas/error.hpp"
#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr std::size_t kYaw = 3;                    // among the axes of sway
constexpr double kSwing = std::numbers::pi / 9.0;  // rad to each side, if the path swings

// Returns the perimeter of an ellipse by Ramanujan's approximation of 1914.
double perimeter_m(double a, double b) {
    const double h = (a - b) * (a - b) / ((a + b) * (a + b));
    return std::numbers::pi * (a + b) * (1.0 + 3.0 * h / (10.0 + std::sqrt(4.0 - 3.0 * h)));
}

// Returns a root of an increasing function.
template <typename Function>
double bisect(double low, double high, const Function& function) {
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (function(middle) < 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

}  // namespace

DiverMotion::DiverMotion(const SurveyPath& path, std::uint64_t seed) : path_(path) {
    base::RandomRow random(base::hash64(seed, 0x6d6f74696f6eULL));
    // Slow drift of the diver, breathing, and the stroke of the fins.
    struct Band {
        double low_hz;
        double high_hz;
        double share;
    };
    constexpr std::array<Band, 4> kBands = {
        {{0.05, 0.09, 1.0}, {0.13, 0.22, 0.6}, {0.35, 0.55, 0.22}, {0.8, 1.1, 0.08}}};
    constexpr std::array<double, 6> kAmplitudes = {0.06, 0.06, 0.05, 0.07, 0.045, 0.05};
    for (std::size_t axis = 0; axis < sways_.size(); ++axis)
        for (const Band& band : kBands)
            sways_[axis].push_back(
                {path_.sway * kAmplitudes[axis] * band.share * random.uniform(0.7, 1.1),
                 random.uniform(band.low_hz, band.high_hz),
                 random.uniform(0.0, kTwoPi)});
    if (path_.swing_rad_s > 0.0)
        sways_[kYaw].push_back({kSwing, path_.swing_rad_s / (kTwoPi * kSwing), 0.0});
    angle_rate_ = path_.speed_m_s / perimeter_m(path_.semi_axis_x_m, path_.semi_axis_y_m) * kTwoPi;
}

DiverMotion DiverMotion::open_path(const SurveyPath& path, double length_m, std::uint64_t seed) {
    DiverMotion motion(path, seed);
    motion.widening_ = 0.008;
    const double guess_s = length_m / path.speed_m_s;
    motion.path_duration_s_ = bisect(0.1 * guess_s, 10.0 * guess_s, [&](double duration_s) {
        return motion.length_m(duration_s) - length_m;
    });
    return motion;
}

DiverMotion DiverMotion::closed_lap(const SurveyPath& path,
                                    double length_m,
                                    double rate_hz,
                                    std::uint64_t seed) {
    if (path.straight)
        throw Error(
            ErrorCode::InvalidArgument,
            "this scene is a straight swim without laps: leave out --laps or choose another scene");
    const double lap_s = std::max(1.0, std::round(length_m / path.speed_m_s * rate_hz)) / rate_hz;
    const auto scaled = [&](double scale) {
        SurveyPath lap = path;
        lap.semi_axis_x_m *= scale;
        lap.semi_axis_y_m *= scale;
        DiverMotion motion(lap, seed);
        motion.close(lap_s);
        return motion;
    };
    const double min_length_m = scaled(0.0).length_m(lap_s);
    const double max_length_m = scaled(path.max_scale).length_m(lap_s);
    if (length_m < min_length_m || length_m > max_length_m)
        throw Error(ErrorCode::InvalidArgument,
                    "a closed lap of " + std::to_string(length_m) +
                        " m does not fit this scene: choose a length up to " +
                        std::to_string(max_length_m) + " m, or an open path");
    const double scale = bisect(0.0, path.max_scale, [&](double candidate) {
        return scaled(candidate).length_m(lap_s) - length_m;
    });
    return scaled(scale);
}

DiverMotion DiverMotion::with_pauses(const std::vector<Stretch>& pauses) const {
    std::vector<Rest> rests;
    rests.reserve(pauses.size());
    for (const Stretch& pause : pauses)
        rests.push_back({pause.at_share * path_duration_s_, pause.duration_s});
    DiverMotion motion = *this;
    motion.path_time_ = PathTime(rests);
    return motion;
}

double DiverMotion::duration_s() const { return path_time_.end_of(path_duration_s_); }

void DiverMotion::close(double lap_s) {
    path_duration_s_ = lap_s;
    angle_rate_ = kTwoPi / lap_s;
    for (Sways& sways : sways_)
        for (Sway& sway : sways)
            sway.frequency_hz = std::max(1.0, std::round(sway.frequency_hz * lap_s)) / lap_s;
}

Jet DiverMotion::sum(const Sways& sways, const Jet& t) const {
    Jet result;
    for (const Sway& sway : sways)
        result = result + sway.amplitude * sin((kTwoPi * sway.frequency_hz) * t + sway.phase);
    return result;
}

DiverMotion::Way DiverMotion::line_at(const Jet& t) const {
    return {path_.speed_m_s * t, {}, constant(path_.look_yaw)};
}

DiverMotion::Way DiverMotion::ellipse_at(const Jet& t) const {
    const Jet angle = angle_rate_ * t + path_.start_angle;
    const Jet grown = (widening_ * angle_rate_) * t + 1.0;
    return {path_.semi_axis_x_m * (grown * cos(angle)),
            path_.semi_axis_y_m * (grown * sin(angle)),
            angle + (0.5 * std::numbers::pi + path_.look_yaw)};
}

MotionState DiverMotion::at(double t_s) const {
    const Jet t = path_time_.at(t_s);
    const Way way = path_.straight ? line_at(t) : ellipse_at(t);
    const Jet x = way.x + sum(sways_[0], t);
    const Jet y = way.y + sum(sways_[1], t);
    const Jet z = sum(sways_[2], t);
    const Jet yaw = way.yaw + sum(sways_[3], t);
    const Jet pitch = sum(sways_[4], t) + path_.look_pitch;
    const Jet roll = sum(sways_[5], t);

    MotionState state;
    state.T_world_imu.linear() = (Eigen::AngleAxisd(yaw.value, Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(pitch.value, Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(roll.value, Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
    state.T_world_imu.translation() =
        path_.center_world + Eigen::Vector3d(x.value, y.value, z.value);
    state.velocity_world = {x.first, y.first, z.first};
    state.acceleration_world = {x.second, y.second, z.second};
    // Converts the rates of the z-y-x angles to the body frame.
    const double sin_roll = std::sin(roll.value);
    const double cos_roll = std::cos(roll.value);
    const double sin_pitch = std::sin(pitch.value);
    const double cos_pitch = std::cos(pitch.value);
    state.angular_velocity_imu = {roll.first - yaw.first * sin_pitch,
                                  pitch.first * cos_roll + yaw.first * cos_pitch * sin_roll,
                                  -pitch.first * sin_roll + yaw.first * cos_pitch * cos_roll};
    return state;
}

double DiverMotion::length_m(double path_duration_s) const {
    const int num_steps = std::max(16, static_cast<int>(std::lround(path_duration_s * 20.0)));
    const double step_s = path_duration_s / num_steps;
    double sum_m = 0.0;  // midpoint rule
    for (int i = 0; i < num_steps; ++i)
        sum_m += at((i + 0.5) * step_s).velocity_world.norm() * step_s;
    return sum_m;
}

}  // namespace divemesh::simulator
