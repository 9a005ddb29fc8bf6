#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace divemesh::stats {

// Returns the median: the middle value, or the mean of the two middle values; 0 for an empty
// vector.
inline double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 == 1) return *middle;
    return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

// Returns the upper median: the middle value, or the larger of the two middle values, so that it is
// always one of the values; 0 for an empty vector. Estimators use it for their scale or gate.
template <typename Value>
Value upper_median(std::vector<Value> values) {
    if (values.empty()) return Value{};
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace divemesh::stats
