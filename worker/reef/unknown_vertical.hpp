#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <vector>

#include "worker/reef/area_set.hpp"

namespace divemesh::reef {

// What can be measured where no sensor tells which way is up, and world z may point anywhere.

// Returns the set with a normal for each outline that gives none: that of its corners, on the side
// of the camera nearest to it.
AreaSet facing_cameras(AreaSet set, const std::vector<Eigen::Vector3d>& camera_positions_world);

// Refuses what depends on the vertical in a result of measure_areas(): metrics of the whole model
// except the sizes of its colonies, slope and aspect, and transects without a normal.
void refuse_by_vertical(const AreaSet& set, nlohmann::json& result);

}  // namespace divemesh::reef
