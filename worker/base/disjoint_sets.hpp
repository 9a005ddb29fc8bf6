#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace divemesh::base {

// Union-find (Tarjan 1975, with path halving). The lowest member represents its set.
class DisjointSets {
public:
    explicit DisjointSets(std::size_t num) : parent_(num) {
        std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    }
    std::size_t find(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::size_t a, std::size_t b) {
        const std::size_t of_a = find(a);
        const std::size_t of_b = find(b);
        parent_[std::max(of_a, of_b)] = std::min(of_a, of_b);
    }

private:
    std::vector<std::size_t> parent_;
};

}  // namespace divemesh::base
