#pragma once

#include <cstddef>
#include <vector>

namespace divemesh::loops {

// A largest set of vertices of which any two are joined; `joined` is symmetric. Branch and bound
// with greedy colouring as the bound (Tomita and Seki 2003); a graph too hard for a quarter of a
// million branches gives the best set found by then. Returns indices, rising.
std::vector<std::size_t> max_clique(const std::vector<std::vector<bool>>& joined);

}  // namespace divemesh::loops
