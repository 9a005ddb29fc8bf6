#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/area_set.hpp"

namespace divemesh::reef {

// The ground on which colonies were counted: the quadrats that carry no label, else all that was
// seen.
struct SurveyedGround {
    std::string name;  // as the figures' area
    double seen_m2 = 0.0;
    std::vector<AreaPlane> quadrats;  // none: everywhere
};

// Colonies (polygons and quadrats with a label) per m2, cover, and the quartiles of their areas and
// diameters, label by label, as entries of "figures". A colony counts where the mean of its corners
// lies over a quadrat.
nlohmann::json measure_labels(const AreaSet& set, const SurveyedGround& ground, std::uint64_t seed);

}  // namespace divemesh::reef
