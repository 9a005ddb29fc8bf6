#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "worker/evaluation/scale_check.hpp"

namespace divemesh::evaluation {

// A sensor that measures lengths, and its scale against the cameras.
struct ScaleSource {
    std::string name;
    ScaleCheck check;
};

// What several sensors say of the scale together, each weighted by its sigma, and what follows from
// that and from the cameras' own calibration.
struct CombinedScale {
    std::vector<ScaleSource> sources;
    ScaleCheck sensors;  // their mean; sigma larger if they disagree (Birge 1932)
    // All lengths have to be multiplied by it: the sensors' scale weighted with the cameras', or
    // the sensors' alone if it is more than three sigmas of both together from 1, as then the rig
    // is not as it was calibrated.
    double factor = 1.0;
    double sigma = 0.0;         // of the factor
    bool contradicted = false;  // the sensors' mean is more than three of its sigmas from 1
};

// Returns the scale by sensors and by cameras whose own scale has the sigma `cameras_sigma`.
// `sources` must not be empty.
CombinedScale combined_scale(std::vector<ScaleSource> sources, double cameras_sigma);

nlohmann::json to_metrics(const CombinedScale& scale);

}  // namespace divemesh::evaluation
