#pragma once

#include "worker/types/mesh.hpp"

namespace divemesh::mesh {

// Converts the standard deviations from fusion, which assume independent views, into those of the
// finished surface, along the normal. With W = 1 / sigma^2 the sum of the views' weights, n the
// number of views and v the vertex's voxel_m (without it term 2 is left out):
//
//     sigma^2 = (1 + (n - 1) r) / W  +  (c v theta)^2  +  sigma_poses^2
//
// 1. The errors of views of one place are correlated, by a share r of their variance: of the
//    0.15 px that a disparity is never better than, interpolation (pixel locking), calibration and
//    slant leave some 0.035 px that does not change from view to view, r = (0.035 / 0.15)^2 = 0.05.
//    The mean of n such views has 1 + (n - 1) r times the variance of independent ones (Kish's
//    design effect, 1965).
// 2. Matching (a window of 7 px, 1.4 v to either side) and truncation (3 v) flatten curved surface:
//    the mean of a curve of curvature k over R to either side is off by k R^2 / 6. theta is how far
//    the normals around a vertex spread, twice over its neighbours, k 0.84 v; so c = 4.4^2 / 6 /
//    0.84, about 3.5 (a wider bend is flattened by as much in either direction).
// 3. The poses move the surface: sigma_poses_m, the part of the error that is shared by all
//    vertices near each other.
//
// sigma_local_m keeps only term 1, noise, which makes the surface rougher; term 2 makes it smoother
// and term 3 moves all vertices alike. Positions and normals do not change. Not covered: fish and
// snow taken for surface, and calibration errors beyond the stated ones. Where another measurement
// contradicts the scale, what that would move is added at the end (evaluation::with_scale_sigma).
void finish_sigma(types::Mesh& mesh, double sigma_poses_m);

}  // namespace divemesh::mesh
