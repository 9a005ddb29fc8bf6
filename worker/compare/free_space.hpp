#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "worker/evaluation/surface_index.hpp"
#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::compare {

// Pinhole views of a dive, as stored in keyframes.json.
struct Views {
    double focal_px = 0.0;
    Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d size_px = Eigen::Vector2d::Zero();
    std::vector<Eigen::Isometry3d> T_cam_world;
};

// Reads the views of the largest tracking segment from keyframes.json; nullopt if the file is
// missing. Throws Error{BadData} if it is not in our format.
std::optional<Views> read_views(const io::ReconstructionFolder& folder);

// Returns whether a view looked through point p at the mesh at least `behind_m` behind it: then the
// dive shows that p was free.
bool is_free_space(const Views& views,
                   const evaluation::SurfaceIndex& surface,
                   const Eigen::Vector3d& p_world,
                   double behind_m);

}  // namespace divemesh::compare
