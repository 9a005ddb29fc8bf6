#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace divemesh::base {

// Random numbers as a function of where they are needed, not of the order of the calls, so that the
// results do not depend on the number of threads.
constexpr std::uint64_t hash64(std::uint64_t value) {  // finaliser of splitmix64 (Steele 2014)
    value += 0x9e3779b97f4a7c15ULL;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9ULL;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebULL;
    return value ^ (value >> 31);
}

template <typename... Rest>
constexpr std::uint64_t hash64(std::uint64_t first, Rest... rest) {
    return hash64(first ^ (hash64(static_cast<std::uint64_t>(rest)...) * 0xd6e8feb86659fd93ULL));
}

// Returns a number in [0, 1) made from a hash.
constexpr double to_unit(std::uint64_t hash) { return static_cast<double>(hash >> 11) * 0x1.0p-53; }

// A sequence of random numbers from one seed, for scenes and sensors that are built one after the
// other.
class RandomRow {
public:
    explicit RandomRow(std::uint64_t seed) : seed_(seed) {}

    double uniform(double low, double high) { return low + (high - low) * to_unit(next()); }
    double gaussian() {  // Box and Muller 1958
        const double u = 1.0 - to_unit(next());
        return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * to_unit(next()));
    }
    std::uint64_t next() { return hash64(seed_, ++counter_); }

private:
    std::uint64_t seed_;
    std::uint64_t counter_ = 0;
};

}  // namespace divemesh::base
