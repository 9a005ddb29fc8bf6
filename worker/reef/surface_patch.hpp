#pragma once

#include <optional>
#include <vector>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/height_grid.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::reef {

// The part of a mesh over an area, in the frame of the area's plane, m.
struct SurfacePatch {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Eigen::Vector3d> normals;  // unit
    std::vector<double> sigma_m;           // along the normal, total; 0: unknown
    std::vector<double> sigma_local_m;     // its noise part, if the mesh has it
    std::vector<double> sigma_bend_m;      // the rest: lost in bends or moved by poses
    Triangles triangles;
    std::vector<double> share_within;  // of each triangle's area, within the outline; 1 for a line
};

// Returns every triangle within `margin_m` of the outline's bounds, because noise may move near
// ones into it.
SurfacePatch cut_patch(const types::Mesh& mesh, const AreaPlane& plane, double margin_m);

// Returns the area of the triangles over the outline, with the vertices at these places. Every
// layer counts, overhangs too (habtools surface_area).
double surface_area_m2(const SurfacePatch& patch, const std::vector<Eigen::Vector3d>& vertices);

// Returns the RMS of the known sigmas; nullopt if none is known.
std::optional<double> typical_sigma_m(const std::vector<double>& sigma_m);
// Returns the sigma that 80 % of the triangles' area within the outline does not exceed, so that a
// few vague vertices do not decide it. `sigma_m`: one per vertex; nullopt if none is known.
std::optional<double> sigma_of_most_m(const SurfacePatch& patch,
                                      const std::vector<double>& sigma_m);
// Returns the median distance of the vertices to their nearest camera, m; nullopt without cameras
// or vertices.
std::optional<double> median_range_m(const SurfacePatch& patch,
                                     const std::vector<Eigen::Vector3d>& cameras_plane);
double median_edge_m(const SurfacePatch& patch);  // 0 without triangles

}  // namespace divemesh::reef
