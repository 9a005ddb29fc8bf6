#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

// What a mesh says about itself. Shares are of its area, spread over vertices; a vertex errs along
// its normal, by a normal number of its own sigma.
struct ExpectedSurface {
    double share_1_view = 0.0;
    double share_2_views = 0.0;
    double share_3_views_or_more = 0.0;
    double sigma_median_m = 0.0;
    double sigma_p95_m = 0.0;
    std::optional<double> sigma_local_median_m;  // of the noise alone
    double error_95_m = 0.0;  // 95 % of the area is expected within this of the true surface
};

// Nothing for a mesh without area or without sigma.
std::optional<ExpectedSurface> expected_surface(const types::Mesh& mesh);

nlohmann::json to_metrics(const ExpectedSurface& surface);

}  // namespace divemesh::evaluation
