#pragma once

#include <cstddef>
#include <vector>

namespace divemesh::loops {

// Returns a max clique, i.e. a largest set of pairwise joined vertices; `joined` is symmetric.
// Branch and bound with greedy colouring as the bound (Tomita and Seki 2003); after a quarter of a
// million branches it returns the best set found so far. The indices ascend.
std::vector<std::size_t> max_clique(const std::vector<std::vector<bool>>& joined);

}  // namespace divemesh::loops
