#pragma once

#include <optional>
#include <vector>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/height_grid.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::reef {

// The part of a mesh that lies over an area, in the frame of the area's plane, m.
struct SurfacePatch {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector3d> normals;  // unit
    std::vector<double> sigma_m;           // along the normal, all of it; 0: unknown
    std::vector<double> sigma_local_m;     // the noise in it, where the mesh tells it apart
    std::vector<double> sigma_bend_m;      // the rest: what bends lose and poses move
    Triangles triangles;
    std::vector<double> share_within;  // of each triangle's area, the area's outline
};

// Every triangle within `margin_m` of the outline's bounds: noise moves what is near them.
SurfacePatch cut_patch(const types::Mesh& mesh, const AreaPlane& plane, double margin_m);

// Area of the triangles over the outline, every sheet of them, overhangs too (habtools
// surface_area), with the vertices at these places.
double surface_area_m2(const SurfacePatch& patch, const std::vector<Eigen::Vector3d>& vertices);

// Root of the mean squares over those that are known; nothing when none is.
std::optional<double> typical_sigma_m(const std::vector<double>& sigma_m);
// Of the vertices to the nearest of the cameras, the median; nothing without cameras or vertices.
std::optional<double> median_range_m(const SurfacePatch& patch,
                                     const std::vector<Eigen::Vector3d>& cameras_plane);
double median_edge_m(const SurfacePatch& patch);  // 0 without triangles

}  // namespace divemesh::reef
