#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace divemesh::stats {

// Returns the median: the middle value, of an even number the mean of the two in the middle; 0 of
// none.
inline double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 == 1) return *middle;
    return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

// Returns the upper median: the middle value, of an even number the larger of the two in the
// middle, so that it is always one of the values; 0 of none. What an estimator takes as its scale
// or its gate.
template <typename Value>
Value upper_median(std::vector<Value> values) {
    if (values.empty()) return Value{};
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace divemesh::stats
