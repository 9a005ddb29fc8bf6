#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string_view>

#include "worker/types/rig.hpp"

namespace divemesh::io {

std::string_view to_string(types::Distortion distortion);  // as in LensModel::name

// Returns how many coefficients of the lens are written.
std::size_t num_stated_coefficients(const types::Camera& camera);

// A pose as our JSON files have it: position_m, orientation_wxyz. Reading throws Error{BadData} for
// an orientation that is no unit quaternion.
nlohmann::json to_json(const Eigen::Isometry3d& T);
Eigen::Isometry3d pose_from_json(const nlohmann::json& entry);

// Both cameras with their lenses and their poses on the body; the noise of the IMU is no part of
// it. Reading throws Error{BadData} for an unknown lens model and for more coefficients than any
// has.
nlohmann::json to_json(const types::Rig& rig);
types::Rig rig_from_json(const nlohmann::json& entry);

}  // namespace divemesh::io
