#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "worker/evaluation/scale_sources.hpp"

namespace divemesh::evaluation {

// The scale by several sensors together, weighted by sigma, and its comparison with the cameras'
// calibration.
struct CombinedScale {
    std::vector<ScaleSource> sources;
    ScaleCheck sensors;  // their mean; sigma larger if they disagree (Birge 1932)
    // All lengths have to be multiplied by it: the sensors' scale weighted with the cameras', or
    // the sensors' alone if the calibration is refuted.
    double factor = 1.0;
    double sigma = 0.0;    // of the factor
    bool differs = false;  // the sensors' mean is more than three of its sigmas from 1
    bool refuted = false;  // and more than three sigmas of both together: the calibration is wrong
    // The sensors' sigma is at most three quarters of the cameras', and at most 1 %.
    bool is_better = false;
};

// Returns the scale by sensors and by cameras whose own scale has the sigma `cameras_sigma`.
// `sources` must not be empty.
CombinedScale combined_scale(std::vector<ScaleSource> sources, double cameras_sigma);

// Returns the scale by which the result has to be multiplied: if the sensors' mean differs from the
// cameras' scale, or is known clearly better. Returns nullopt otherwise. Also returns nullopt if
// the two differ by more than 10 % (a size was stated wrong), or if the path has no stated error
// (`cameras_sigma` 0).
std::optional<CombinedScale> scale_correction(const std::vector<ScaleSource>& sources,
                                              double cameras_sigma);

nlohmann::json to_metrics(const CombinedScale& scale);

}  // namespace divemesh::evaluation
