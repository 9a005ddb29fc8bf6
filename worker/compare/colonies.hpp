#pragma once

#include <string>
#include <vector>

#include "worker/compare/outlined_cells.hpp"
#include "worker/reef/area_set.hpp"

namespace divemesh::compare {

// An outline with a label, as seen from above in the earlier dive's frame.
struct Colony {
    std::string name;
    std::string label;
    reef::Polygon outline;
    double area_m2 = 0.0;
    double diameter_m = 0.0;
    double share = 0.0;  // of its area that lies on the compared ground
};

// Returns the colonies of a set. `ground` (CV_8U, of the grid): where colonies are compared.
std::vector<Colony> colonies_of(const reef::AreaSet& set,
                                const RasterGrid& grid,
                                const cv::Mat& ground);

// The same colony in the earlier and the later dive, by indices; -1 in `after`: gone, in `before`:
// new.
struct ColonyPair {
    int before = -1;
    int after = -1;
};

// Matches colonies of one label. Two are the same if their outlines overlap most, by at least a
// quarter of the smaller one; each matches one other at most. A colony without a match is gone or
// new. Returns those of the earlier dive in their order, then the new ones.
std::vector<ColonyPair> match_colonies(const std::vector<Colony>& before,
                                       const std::vector<Colony>& after);

}  // namespace divemesh::compare
