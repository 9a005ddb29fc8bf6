#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <vector>

#include "worker/evaluation/surface_index.hpp"

namespace divemesh::compare {

// Pinhole views of a dive, as keyframes.json has them.
struct Views {
    double focal_px = 0.0;
    Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d size_px = Eigen::Vector2d::Zero();
    std::vector<Eigen::Isometry3d> T_cam_world;
};

// Of keyframes.json in the folder of a reconstruction; nothing when there is none. Throws
// Error{BadData} when it is not as we write it.
std::optional<Views> read_views(const std::filesystem::path& folder);

// Whether some view looked through place p at the mesh behind it, at least `behind_m` farther: the
// dive then knows that p was free.
bool is_free_space(const Views& views,
                   const evaluation::SurfaceIndex& surface,
                   const Eigen::Vector3d& p_world,
                   double behind_m);

}  // namespace divemesh::compare
