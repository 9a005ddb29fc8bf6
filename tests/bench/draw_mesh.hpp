#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "worker/io/textured_mesh.hpp"

namespace divemesh::bench {

// An image of a mesh: where from, and how large.
struct Viewpoint {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();  // z forward, y down
    double focal_px = 0.0;
    cv::Size size_px;
    std::optional<Eigen::Vector2d> center_px = std::nullopt;  // nullopt: the middle of the image
};

// Returns the mesh as a viewer shows it (CV_8UC3 BGR): triangles from both sides, with their
// texture or the colours of their vertices, unlit; magenta where there is no mesh. Throws
// Error{BadData} if an atlas cannot be decoded.
cv::Mat draw_mesh(const io::TexturedMesh& shown, const Viewpoint& viewpoint);

// Returns the viewpoint from a direction (unit, from the mesh to the viewer) at which the image
// just holds the mesh, without the outermost fiftieth of its vertices along each axis.
Viewpoint whole_view(const types::Mesh& mesh, const Eigen::Vector3d& direction);

// Returns the viewpoint of a surface near the middle of the mesh from a sixth of that distance.
Viewpoint close_view(const types::Mesh& mesh, const Eigen::Vector3d& direction);

}  // namespace divemesh::bench
