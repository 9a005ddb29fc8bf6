#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "worker/compare/colonies.hpp"

namespace divemesh::compare {

// The colonies of both dives with their matches.
struct ComparedColonies {
    const std::vector<Colony>& before;
    const std::vector<Colony>& after;
    const std::vector<ColonyPair>& pairs;
    double surveyed_m2 = 0.0;
    bool have_later = true;  // false: outlines of one year only, so no change is possible
};

// Returns entries of "figures" for each label: count, population_density, cover,
// colony_area_median, colony_diameter_median. A colony counts if at least half of it, on the mean
// of both years, lies on the surveyed ground; cover counts the part that lies on it.
nlohmann::json label_changes(const ComparedColonies& colonies, std::uint64_t seed);

}  // namespace divemesh::compare
