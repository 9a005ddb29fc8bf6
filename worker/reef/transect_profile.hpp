#pragma once

#include <vector>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/height_grid.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/simulate_metrics.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// A straight piece of the line with the mesh around it; samples at whole steps of the line.
struct TransectSegment {
    AreaPlane plane;
    GridShape shape;  // one row
    double first_along_m = 0.0;
    double datum_m = 0.0;  // of its heights, against the first piece's
};

std::vector<TransectSegment> segments_of(const std::vector<Eigen::Vector3d>& line,
                                         const Eigen::Vector3d& normal);

using Profile = std::vector<ProfilePoint>;  // kUnseen_m: no surface there

// The highest surface along all pieces, every 5 mm, with the patches' vertices at these places.
Profile profile_of(const std::vector<TransectSegment>& segments,
                   const std::vector<SurfacePatch>& patches,
                   const Places& places);

// What sampling at that spacing, a multiple of 5 mm, would have given.
Profile every(const Profile& profile, double spacing_m);

// Means of the seen heights within this length around each seen point.
Profile blurred(const Profile& profile, double side_m);

// The straight line over every gap between what was seen.
Profile gaps_filled(Profile profile);

double coverage_of(const Profile& profile);  // share that was seen

}  // namespace divemesh::reef
