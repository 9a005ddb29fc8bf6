#pragma once

#include <Eigen/Geometry>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "worker/evaluation/trajectory_error.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/simulator/ray_caster.hpp"
#include "worker/simulator/scene.hpp"

namespace divemesh::synthetic {

// The true change of height between two scenes, from their geometry, in the cells of a comparison.
class TrueChange {
public:
    struct Sums {
        double grown_m3 = 0.0;
        double lost_m3 = 0.0;
        double changed_m2 = 0.0;
    };

    // `model_a` and `comparison` are folders. `truth_a` is the true path of the earlier dive, which
    // gives the pose of the model's world in the scene.
    TrueChange(const simulator::Scene& before,
               const simulator::Scene& after,
               const std::filesystem::path& model_a,
               const std::filesystem::path& truth_a,
               const std::filesystem::path& comparison)
        : before_(before.vertices, before.triangles),
          after_(after.vertices, after.triangles),
          scale_(nlohmann::json::parse(std::ifstream(comparison / "mosaic_difference.json"))),
          heights_(cv::imread((comparison / "change_height.png").string(), cv::IMREAD_UNCHANGED)) {
        T_scene_a_ =
            evaluation::trajectory_error(io::read_trajectory(model_a / "trajectory.tum").poses,
                                         io::read_trajectory(truth_a).poses)
                .T_reference_surface;
    }

    // Returns the sums over the compared cells whose centres lie in the box (frame of the
    // comparison).
    Sums in(const Eigen::AlignedBox2d& box) const {
        Sums sums;
        const double pixel_m = scale_.at("pixel_m");
        const double west_m = scale_.at("corner_x_m");
        const double north_m = scale_.at("corner_y_m");
        for (int row = 0; row < heights_.rows; ++row)
            for (int column = 0; column < heights_.cols; ++column) {
                const Eigen::Vector2d at(west_m + pixel_m * (column + 0.5),
                                         north_m - pixel_m * (row + 0.5));
                if (heights_.at<std::uint16_t>(row, column) == 0 || !box.contains(at)) continue;
                const double change_m = change_at(at);
                (change_m > 0.0 ? sums.grown_m3 : sums.lost_m3) +=
                    std::abs(change_m) * pixel_m * pixel_m;
                if (std::abs(change_m) > 1e-3) sums.changed_m2 += pixel_m * pixel_m;
            }
        return sums;
    }
    Sums all() const {
        return in({Eigen::Vector2d::Constant(-1e6), Eigen::Vector2d::Constant(1e6)});
    }

private:
    double change_at(const Eigen::Vector2d& place) const {
        const Eigen::Vector3d p = T_scene_a_ * Eigen::Vector3d(place.x(), place.y(), 20.0);
        const Eigen::Vector3d down = T_scene_a_.linear() * -Eigen::Vector3d::UnitZ();
        const auto first = before_.cast(p.cast<float>(), down.cast<float>());
        const auto second = after_.cast(p.cast<float>(), down.cast<float>());
        return first.valid() && second.valid() ? static_cast<double>(first.t - second.t) : 0.0;
    }

    simulator::RayCaster before_;
    simulator::RayCaster after_;
    nlohmann::json scale_;
    cv::Mat heights_;
    Eigen::Isometry3d T_scene_a_;
};

}  // namespace divemesh::synthetic
