#pragma once

#include <string>

#include "worker/camera/lens_model.hpp"
#include "worker/dive/sensor_yaml.hpp"

namespace divemesh::dive {

// Returns any lens model of the camera_model that sensor.yaml states: those of one camera_model
// share their intrinsics. nullptr if there is none.
const camera::LensModel* camera_model_of(const SensorYaml& yaml);

// Returns the smallest lens model that has the camera_model, the distortion_model and all
// distortion_coefficients other than 0; nullptr if there is none, or coefficients are missing.
const camera::LensModel* lens_model_of(const SensorYaml& yaml);

// Returns true if a lens model of the camera_model has the distortion_model.
bool is_distortion_known(const SensorYaml& yaml);

// Returns the names of the intrinsics: "xi, alpha, fu, fv, cu, cv".
std::string intrinsics_names(const camera::LensModel& model);

// Takes over intrinsics and distortion_coefficients, as many as the model has, as Camera has them.
void read_lens(const SensorYaml& yaml, const camera::LensModel& model, types::Camera& camera);

// States the lens of a camera in sensor.yaml: camera_model, intrinsics, distortion_model and
// distortion_coefficients.
void state_lens(const types::Camera& camera, SensorYaml& yaml);

}  // namespace divemesh::dive
