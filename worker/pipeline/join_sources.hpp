#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "worker/optimisation/join_path.hpp"
#include "worker/pipeline/outside_points.hpp"
#include "worker/types/georeference.hpp"

namespace divemesh::pipeline {

// The sources that agree with the path, and the path joined with them.
struct JoinedSources {
    optimisation::JoinedPath joined;
    double prior_factor = 1.0;  // on the sigmas of the path, as the positions show them
    std::vector<types::SourceAgreement> sources;
};

// Returns the points of all sources with timestamps that are later by some seconds.
using PointsAt = std::function<std::vector<SourcePoints>(double later_s)>;

// Joins the path with all sources that agree with it. The sigmas of a source grow to the spread of
// its residuals, and by how much neighbouring residuals are alike; those of the path to what the
// sources show of it (variance components, Foerstner 1979). A source that is more than four
// times as far off as it states, that fits a mirrored path or another clock, or of which less than
// half fits is left out, and its agreement says why. `joined` has not converged if nothing is left
// to join.
JoinedSources join_sources(const PathToJoin& to_join,
                           const PointsAt& points_at,
                           const std::vector<optimisation::OutsideMotion>& motions,
                           const optimisation::JoinSettings& settings);

}  // namespace divemesh::pipeline
