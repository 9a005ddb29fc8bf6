#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "worker/loops/loop.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"

namespace divemesh::loops {

inline constexpr std::size_t kLap = 60;

// A lap and a sixth around a circle of 3 m radius. In the estimate, each step rotates too far by
// `yaw_error`.
struct Laps {
    explicit Laps(double yaw_error, std::size_t blind_at = 0) {
        Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
        for (std::size_t k = 0; k < kLap + 10; ++k) {
            const double angle =
                2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(kLap);
            Eigen::Isometry3d T_true = Eigen::Isometry3d::Identity();
            T_true.translation() << 3.0 * std::cos(angle), 3.0 * std::sin(angle), 0.0;
            T_true.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
            if (k == 0)
                T_world_cam = T_true;
            else
                T_world_cam = T_world_cam * (truth.back().inverse() * T_true) *
                              Eigen::AngleAxisd(yaw_error, Eigen::Vector3d::UnitZ());
            truth.push_back(T_true);
            keyframes.push_back(
                {static_cast<int>(k), static_cast<std::int64_t>(k) * 1'000'000'000, T_world_cam});
        }
        for (std::size_t k = 0; k + 1 < keyframes.size(); ++k) {
            if (k + 1 == blind_at) continue;
            for (int i = 0; i < 10; ++i) {
                types::Landmark landmark;
                landmark.p_world = keyframes[k].T_world_cam * Eigen::Vector3d(0.1 * i, 0.0, 2.0);
                landmark.observations = {{static_cast<std::int32_t>(k)},
                                         {static_cast<std::int32_t>(k + 1)}};
                landmarks.push_back(landmark);
            }
        }
    }

    Loop loop(std::size_t from, std::size_t to) const {
        Loop loop;
        loop.from = from;
        loop.to = to;
        loop.T_from_to = truth[from].inverse() * truth[to];
        loop.sigma_m = 0.01;
        return loop;
    }
    // Returns a loop that claims that both keyframes have the same pose.
    static Loop false_loop(std::size_t from, std::size_t to) {
        Loop loop;
        loop.from = from;
        loop.to = to;
        loop.sigma_m = 0.01;
        return loop;
    }

    std::vector<Eigen::Isometry3d> truth;
    std::vector<types::Keyframe> keyframes;
    std::vector<types::Landmark> landmarks;
};

}  // namespace divemesh::loops
