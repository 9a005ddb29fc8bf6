#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

// Quantiles of a sample. `share` is between 0 and 1; of an empty vector each is 0.
namespace divemesh::stats {

// Returns the quantile of ascending values by linear interpolation between neighbours: type 7 of
// Hyndman and Fan (1996), the default of R and NumPy.
inline double quantile_of_sorted(const std::vector<double>& sorted, double share) {
    if (sorted.empty()) return 0.0;
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

// Returns the value at that rank, rounded down: always one of the values (NumPy's "lower").
template <typename Value>
Value lower_quantile(std::vector<Value> values, double share) {
    if (values.empty()) return Value{};
    const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
}

// Returns the smallest value that more than `share` of all values do not exceed: always one of the
// values; for one half, the upper median.
template <typename Value>
Value upper_quantile(std::vector<Value> values, double share) {
    if (values.empty()) return Value{};
    const auto rank = std::min(static_cast<std::size_t>(share * static_cast<double>(values.size())),
                               values.size() - 1);
    std::nth_element(
        values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
    return values[rank];
}

}  // namespace divemesh::stats
