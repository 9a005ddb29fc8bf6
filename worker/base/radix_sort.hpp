#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace divemesh::base {

// Sorts values by key(value), a std::uint64_t, in linear time; values of equal keys keep their
// order. Calls after_pass() after each of up to eight passes over the values.
template <typename Value, typename Key, typename AfterPass>
void radix_sort(std::vector<Value>& values, const Key& key, const AfterPass& after_pass) {
    constexpr int kDigit_bits = 8;
    constexpr std::uint64_t kMask = (1U << kDigit_bits) - 1;
    std::vector<Value> sorted(values.size());
    std::uint64_t differing = 0;
    for (const Value& value : values) differing |= key(value) ^ key(values.front());
    for (int shift = 0; shift < 64; shift += kDigit_bits) {
        if (((differing >> shift) & kMask) == 0) continue;
        std::array<std::size_t, kMask + 1> begin{};
        for (const Value& value : values) ++begin[(key(value) >> shift) & kMask];
        std::size_t num_before = 0;
        for (std::size_t& entry : begin) {
            const std::size_t num = entry;
            entry = num_before;
            num_before += num;
        }
        for (const Value& value : values) sorted[begin[(key(value) >> shift) & kMask]++] = value;
        values.swap(sorted);
        after_pass();
    }
}

}  // namespace divemesh::base
