#pragma once

#include <vector>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/height_grid.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/simulate_metrics.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// A straight segment of the line with the mesh around it; samples at whole steps of the line.
struct TransectSegment {
    AreaPlane plane;
    GridShape shape;  // one row
    double first_along_m = 0.0;
    double datum_m = 0.0;  // of its heights, relative to the first segment's
};

// Splits a line, m, at its points into straight segments; heights are along `normal`.
std::vector<TransectSegment> segments_of(const std::vector<Eigen::Vector3d>& line,
                                         const Eigen::Vector3d& normal);

using Profile = std::vector<ProfilePoint>;  // kUnseen_m: no surface there

// Returns the highest surface along all segments, every 5 mm, with the patches' vertices at these
// places.
Profile profile_of(const std::vector<TransectSegment>& segments,
                   const std::vector<SurfacePatch>& patches,
                   const Places& places);

// Returns what sampling at that spacing, a multiple of 5 mm, would give.
Profile every(const Profile& profile, double spacing_m);

// Returns the means of the seen heights within this length around each seen point.
Profile blurred(const Profile& profile, double side_m);

// Fills every gap between seen points with a straight line.
Profile gaps_filled(Profile profile);

double coverage_of(const Profile& profile);  // share of seen points

}  // namespace divemesh::reef
