#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

// The accuracy of a mesh according to its own sigmas and views. Shares are of its area, distributed
// to the vertices; the error of a vertex is along its normal and normally distributed with its own
// sigma.
struct ExpectedSurface {
    double share_1_view = 0.0;
    double share_2_views = 0.0;
    double share_3_views_or_more = 0.0;
    double sigma_median_m = 0.0;
    double sigma_p95_m = 0.0;
    std::optional<double> sigma_local_median_m;  // only the noise
    // 95 % of the area is expected within this distance of the true surface
    double error_95_m = 0.0;
};

// Returns nullopt for a mesh without area or without sigma.
std::optional<ExpectedSurface> expected_surface(const types::Mesh& mesh);

nlohmann::json to_metrics(const ExpectedSurface& surface);

}  // namespace divemesh::evaluation
