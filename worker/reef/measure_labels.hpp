#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/area_set.hpp"
#include "worker/reef/measure_options.hpp"

namespace divemesh::reef {

// The ground on which colonies are counted: the quadrats without a label, otherwise all seen
// ground.
struct SurveyedGround {
    std::string name;  // the area of the metrics
    double seen_m2 = 0.0;
    std::vector<AreaPlane> quadrats;  // empty: everywhere
};

// Returns colonies (polygons and quadrats with a label) per m2, cover, and the quartiles of their
// areas and diameters, for each label, as entries of "figures". A colony counts if the mean of its
// corners lies over a quadrat. All sizes share the error of the scale.
nlohmann::json measure_labels(const AreaSet& set,
                              const SurveyedGround& ground,
                              const MeasureOptions& options);

}  // namespace divemesh::reef
