#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::calibration {

inline constexpr double kDeg = std::numbers::pi / 180.0;
inline constexpr double kNoise_px = 0.2;

// Returns a rig as calibrated: lenses with distortion, cameras half a degree apart.
inline types::Rig stated_rig() {
    types::Rig rig;
    rig.cam0 = {640, 480, 489.6, 489.1, 320.9, 238.8};
    rig.cam0.distortion_coefficients = {-0.121, 0.031, 4e-4, -3e-4};
    rig.cam1 = {640, 480, 491.7, 491.2, 318.3, 241.4};
    rig.cam1.distortion_coefficients = {-0.118, 0.029, -3e-4, 5e-4};
    rig.T_imu_cam0.translation() = Eigen::Vector3d(-0.03, -0.06, 0.04);
    rig.T_imu_cam1 = rig.T_imu_cam0;
    rig.T_imu_cam1.translation().x() += 0.12;
    rig.T_imu_cam1.rotate(base::rotation_from_vector({0.003, 0.007, -0.004}));
    return rig;
}

// Returns the rig with its right camera turned about its own axes.
inline types::Rig knocked(const Eigen::Vector3d& degrees) {
    types::Rig rig = stated_rig();
    rig.T_imu_cam1.rotate(base::rotation_from_vector(kDeg * degrees));
    return rig;
}

// Pairs of a rough floor as a rig records them, rectified with the stated calibration.
class Pairs {
public:
    explicit Pairs(types::Rig rig) : rig_(std::move(rig)) {}

    types::StereoMatches matches(int num_pairs, int num_points, double outlier_share = 0.2) {
        types::StereoMatches found;
        for (const int end = next_pair_ + num_pairs; next_pair_ < end; ++next_pair_)
            for (int i = 0; i < num_points; ++i) add(next_pair_, outlier_share, found);
        return found;
    }
    // Moves the right image of each pair by a row offset of its own.
    void shake_rows(double amplitude_px) { shake_px_ = amplitude_px; }
    // Pairs that are added from now on see the floor at these depths, or with another rig.
    void look_at(double min_depth_m, double max_depth_m) {
        min_depth_m_ = min_depth_m;
        max_depth_m_ = max_depth_m;
    }
    void go_on_with(types::Rig rig) { rig_ = std::move(rig); }

private:
    double uniform(double from, double to) {
        return std::uniform_real_distribution<double>(from, to)(random_);
    }
    Eigen::Vector2d noise() {
        return kNoise_px * Eigen::Vector2d(normal_(random_), normal_(random_));
    }

    void add(int pair, double outlier_share, types::StereoMatches& found) {
        const Eigen::Vector2d left(uniform(0.0, 639.0), uniform(0.0, 479.0));
        const double depth_m = uniform(min_depth_m_, max_depth_m_);
        const Eigen::Vector3d p_cam0 = depth_m * camera::unproject(rig_.cam0, left);
        auto right = camera::project(rig_.cam1, rig_.T_cam1_cam0() * p_cam0);
        if (!right || !camera::contains(rig_.cam1, *right)) return;
        *right += noise() + Eigen::Vector2d(0.0, shake_px_ * std::sin(2.0 * pair));
        types::StereoMatch match{pair,
                                 lenses_[0].rectified_px(rectified_, left),
                                 lenses_[1].rectified_px(rectified_, *right)};
        if (uniform(0.0, 1.0) < outlier_share)
            match.right_px = {uniform(0.0, 639.0), match.left_px.y() + uniform(-19.0, 19.0)};
        found.push_back(match);
    }

    types::Rig rig_;
    types::RectifiedRig rectified_ = camera::Rectifier(stated_rig()).rig();
    std::array<camera::RectifiedLens, 2> lenses_ = camera::rectified_lenses(stated_rig());
    double shake_px_ = 0.0;
    double min_depth_m_ = 1.0;
    double max_depth_m_ = 3.0;
    int next_pair_ = 0;
    std::mt19937 random_{24};
    std::normal_distribution<double> normal_;
};

}  // namespace divemesh::calibration
