#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "worker/evaluation/known_distances.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// A length measured by another sensor divided by the same length from the cameras; 1 if both agree.
struct ScaleCheck {
    double scale = 1.0;
    double sigma = 0.0;  // standard deviation, from the spread of the residuals
};

// Returns true if a scale is more than three of its sigmas from 1.
bool is_contradicted(const ScaleCheck& check);

// Compares the depth by pressure with the vertical motion of the path: the slope of depth over -z,
// with half seconds of the dive as samples; a slope over x and y is free, as the path may be
// slightly tilted. Sigma includes the correlation of consecutive residuals, and is wider the fewer
// of them are independent. It also includes
// `sigma_by_poses` (PathUncertainty::vertical_scale_sigma), the effect of the poses' own errors on
// the slope, because the slope absorbs them and the residuals do not show them. Returns nullopt
// without pressure or with less than ten seconds of it.
std::optional<ScaleCheck> scale_by_pressure(const std::vector<types::PressureSample>& pressure,
                                            const types::Trajectory& trajectory,
                                            double sigma_by_poses);

// The error of two distant places on the path relative to each other, along a line.
struct PathError {
    double far_sigma_m = 0.0;
    // Extent of the path; below it the error grows with the square root of the length.
    double extent_m = 0.0;
};

// Returns the mean of checks that are independent of each other, each weighted by its sigma, whose
// own sigma grows as they disagree (Birge 1932). `checks` must not be empty.
ScaleCheck weighted_mean(const std::vector<ScaleCheck>& checks);

// Compares lengths that were measured in the water with those between the places marked in the
// images. Each length counts by its sigma_m and by what a tape is read to, 2 mm. Returns nullopt if
// none of them was measured with a sigma.
std::optional<ScaleCheck> scale_by_marked_distances(const KnownDistanceErrors& distances);

// Compares known lengths t with measured ones m. Sigma is the spread of the residuals and, in
// quadrature, the effect of the poses on all lengths alike, which the residuals do not show.
// Returns nullopt for fewer than three lengths.
std::optional<ScaleCheck> scale_by_distances(const KnownDistanceErrors& distances,
                                             const PathError& path);

nlohmann::json to_metrics(const ScaleCheck& check);

}  // namespace divemesh::evaluation
