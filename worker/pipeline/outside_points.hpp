#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "worker/optimisation/anchored_path.hpp"
#include "worker/optimisation/join_path.hpp"
#include "worker/pipeline/reconstruction.hpp"
#include "worker/types/georeference.hpp"
#include "worker/types/path_prior.hpp"

namespace divemesh::pipeline {

// A plane at the dive: x east, y north, z up, m.
struct Site {
    types::GeographicPosition origin;
    int utm_epsg = 0;
    Eigen::Matrix<double, 2, 3> A = Eigen::Matrix<double, 2, 3>::Zero();  // io::UtmFrame

    Eigen::Vector3d from_utm(const Eigen::Vector3d& utm_m) const;
    Eigen::Vector3d to_utm(const Eigen::Vector3d& p_site) const;
};

// Returns the site at the first position of a dive that has any.
Site site_of(const types::OutsidePositions& outside);

// The path before it is joined: its segments are where they were estimated to be, not set apart.
struct PathToJoin {
    types::PathPrior prior;
    optimisation::AnchoredPath path;
    types::Trajectory trajectory;
};

// Returns the path of a reconstruction, at its present scale. Without a prior the path is one rigid
// body.
PathToJoin path_to_join(const Reconstruction& made);

// What a source measured, as points that move with the path.
struct SourcePoints {
    types::SourceAgreement agreement;  // name, kind, system and counts of rows
    double offset_sigma_m = 0.0;
    std::vector<optimisation::OutsidePoint> points;
};

// Returns the points of all positions and control points. `later_s` is added to the timestamps of
// positions.
std::vector<SourcePoints> source_points(const Reconstruction& made,
                                        const PathToJoin& to_join,
                                        const Site& site,
                                        double later_s = 0.0);

// What the velocities of a dive tell.
struct VelocityMotions {
    types::SourceAgreement agreement;
    std::vector<optimisation::OutsideMotion> motions;
};

// Returns the motions over every break of the path that the velocities cover. Elsewhere vision
// measures them better, and there the velocities are judged: their sigmas grow to the spread of the
// differences, and where these are more than four times as large, no motion is returned and the
// agreement says why. The body rotates between two anchors as the gyroscope says. nullopt without
// velocities.
std::optional<VelocityMotions> motions_by_velocity(const Reconstruction& made,
                                                   const PathToJoin& to_join);

}  // namespace divemesh::pipeline
