#pragma once

#include <array>
#include <cstdint>

#include "worker/io/record.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// A point of our LAS files: point format 7 (ASPRS LAS 1.4 revision 15, table 16) with the extra
// bytes sigma (m) and number of observations. Every point is return 1 of 1; what has no member here
// (intensity, class, angle, GPS time ...) is 0.
struct LasPoint {
    static constexpr std::uint8_t kFormat = 7;
    static constexpr std::uint16_t kBase_bytes = 30;
    static constexpr std::uint16_t kColor_bytes = 6;
    static constexpr std::uint16_t kExtra_bytes = 8;
    static constexpr std::uint16_t kSize_bytes = kBase_bytes + kColor_bytes + kExtra_bytes;

    std::array<std::int32_t, 3> steps{};  // x, y, z in steps of the file
    types::Color color{};                 // the upper bytes of the file's 16 bits
    float sigma_m = 0.0F;
    std::uint32_t num_observations = 0;
};

inline void put_point(Record& record, const LasPoint& point) {
    constexpr std::uint8_t kOneReturnOfOne = 1 | 1 << 4;
    for (const std::int32_t value : point.steps) record.put(value);
    record.put_zeros(2);  // intensity
    record.put(kOneReturnOfOne);
    record.put_zeros(1 + 1 + 1 + 2 + 2 + 8);  // flags, class, user, angle, source, GPS time
    for (const std::uint8_t channel : point.color) {
        record.put(std::uint8_t{0});
        record.put(channel);
    }
    record.put(point.sigma_m);
    record.put(point.num_observations);
}

}  // namespace divemesh::io
