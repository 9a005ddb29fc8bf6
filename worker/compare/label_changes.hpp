#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>

#include "worker/compare/colonies.hpp"

namespace divemesh::compare {

// What became of the colonies of each label.
struct ComparedColonies {
    const std::vector<Colony>& before;
    const std::vector<Colony>& after;
    const std::vector<ColonyPair>& pairs;
    double surveyed_m2 = 0.0;
    bool have_later = true;  // false: the outlines are of one year, nothing can have changed
};

// Entries of "figures", label by label: count, population_density, cover, colony_area_median,
// colony_diameter_median. A colony counts when at least half of it, on the mean of both years, lies
// on the surveyed ground; cover counts what lies on it.
nlohmann::json label_changes(const ComparedColonies& colonies, std::uint64_t seed);

}  // namespace divemesh::compare
