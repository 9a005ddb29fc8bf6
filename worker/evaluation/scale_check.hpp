#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "worker/evaluation/known_distances.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// A length as another sensor has it over the same length as the cameras have it; 1 when both agree.
struct ScaleCheck {
    double scale = 1.0;
    double sigma = 0.0;  // standard deviation, by the spread of the residuals
};

// Accelerometer against the path. Both are weighed by windows w(t) = sin^4(pi t / T) that overlap
// by half, so that no velocity has to be known (modulating functions, Shinbrot 1957):
//
//     integral w (R_world_imu (a - b) + g) dt = s integral w'' p_world_imu dt
//
// What gravity g differs by from 9.81 m/s^2 along -z, and bias b are unknown and the same for a
// minute, the scale s all along; least squares. Nothing without accelerometer, or where less than
// five windows are covered without a gap.
std::optional<ScaleCheck> scale_by_accelerometer(const std::vector<types::ImuSample>& imu,
                                                 const types::Trajectory& trajectory);

// Depth by pressure against how far up and down the path goes: the slope of depth over -z, half
// seconds of the dive as the samples; a slope over x and y is free, as the path may be tilted a
// little. Residuals that follow one another are alike: their correlation is in sigma. What the
// poses' own errors do to the slope, `sigma_by_poses` (PathUncertainty::vertical_scale_sigma), is
// added: the slope takes up that part of them, so that the residuals do not show it. Nothing
// without pressure or with less than ten seconds of it.
std::optional<ScaleCheck> scale_by_pressure(const std::vector<types::PressureSample>& pressure,
                                            const types::Trajectory& trajectory,
                                            double sigma_by_poses);

// How far two places far apart on the path err against each other along a line.
struct PathError {
    double far_sigma_m = 0.0;
    double extent_m = 0.0;  // of the path; over less the error grows with the root of the length
};

// Known lengths t over measured ones m. Sigma by the spread of the residuals, and in quadrature
// what the poses do to all of the lengths alike, which the residuals cannot show. Nothing for fewer
// than three.
std::optional<ScaleCheck> scale_by_distances(const KnownDistanceErrors& distances,
                                             const PathError& path);

nlohmann::json to_metrics(const ScaleCheck& check);

}  // namespace divemesh::evaluation
