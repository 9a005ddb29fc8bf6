#pragma once

#include <nlohmann/json.hpp>

#include "worker/reef/area_set.hpp"
#include "worker/reef/measure_options.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::reef {

inline constexpr std::string_view kWholeModel = "whole model";  // name of that area

// Measures what ecologists ask of a surface (docs/measuring.md), for the whole model and for each
// area of the set, which is in frame World (m). Returns {"areas": [{name, kind, label?,
// planar_area_m2?, coverage, sigma_m?, detail_m?, ...}], "figures": [{figure, area, label?, unit,
// resolution_m?, value, low, high, method} | {figure, area, label?, unit, resolution_m?, refused}]}
// with [low, high] the 95 % interval. A metric is refused, with the reason, if its resolution is
// below 3 sigma or finer than the surface, if too little of the area was seen, or if it depends on
// a vertical that is not known. The result does not depend on the number of threads. Throws
// Error{InvalidArgument} for an invalid mesh (check_mesh) or a set in another frame.
nlohmann::json measure_areas(const types::Mesh& mesh, const AreaSet& set, MeasureOptions options);

}  // namespace divemesh::reef
