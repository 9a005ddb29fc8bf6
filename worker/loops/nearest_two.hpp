#pragma once

#include <functional>

namespace divemesh::loops {

// The nearest and the second nearest of the descriptors that were offered, by a measure of which
// IsNearer says which of two is nearer. Of equal ones the first counts as the nearest.
template <typename Measure, typename IsNearer = std::less<Measure>>
struct NearestTwo {
    explicit NearestTwo(Measure farthest) : first(farthest), second(farthest) {}

    void offer(int candidate, Measure measure) {
        const IsNearer is_nearer{};
        if (is_nearer(measure, first)) {
            second = first;
            first = measure;
            index = candidate;
        } else if (is_nearer(measure, second)) {
            second = measure;
        }
    }

    int index = -1;  // of the nearest; -1: none
    Measure first;
    Measure second;
};

}  // namespace divemesh::loops
