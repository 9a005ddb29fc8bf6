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
    double share = 0.0;  // of its area that lies on the ground where colonies are compared
};

// `ground` (CV_8U, of the grid): where colonies are compared.
std::vector<Colony> colonies_of(const reef::AreaSet& set,
                                const RasterGrid& grid,
                                const cv::Mat& ground);

// A colony of the earlier dive and the one of the later that is the same: indices; -1: gone, new.
struct ColonyPair {
    int before = -1;
    int after = -1;
};

// Colonies of one label are the same where their outlines have the most in common, and a quarter
// of the smaller at least; each is the same as one other at most. What neither matches is gone or
// new. Those of the earlier dive in their order, then what is new.
std::vector<ColonyPair> match_colonies(const std::vector<Colony>& before,
                                       const std::vector<Colony>& after);

}  // namespace divemesh::compare
