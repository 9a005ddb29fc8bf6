#include "worker/simulator/noise_field.hpp"

#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

constexpr std::uint32_t kNumValues = 4096;  // 64 KiB, fits into the cache
constexpr std::uint32_t kPrimeX = 73856093U;
constexpr std::uint32_t kPrimeY = 19349663U;
constexpr std::uint32_t kPrimeZ = 83492791U;

float quintic(float t) { return t * t * t * (t * (t * 6.0F - 15.0F) + 10.0F); }

// Rounds down; without SSE 4.1, which the baseline lacks, std::floor is a function call.
std::int32_t floor_of(float x) {
    const auto truncated = static_cast<std::int32_t>(x);
    return truncated - (x < static_cast<float>(truncated) ? 1 : 0);
}

std::uint32_t slot(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return ((x ^ y ^ z) >> 11) & (kNumValues - 1);
}

}  // namespace

NoiseField::NoiseField(std::uint64_t seed) : values_(kNumValues) {
    for (std::uint32_t i = 0; i < kNumValues; ++i)
        for (int channel = 0; channel < 4; ++channel)
            values_[i][channel] =
                static_cast<float>(2.0 * base::to_unit(base::hash64(seed, i, channel)) - 1.0);
}

Eigen::Array4f NoiseField::at(const Eigen::Vector3f& p) const {
    const std::int32_t cell_x = floor_of(p.x());
    const std::int32_t cell_y = floor_of(p.y());
    const std::int32_t cell_z = floor_of(p.z());
    const float wx = quintic(p.x() - static_cast<float>(cell_x));
    const float wy = quintic(p.y() - static_cast<float>(cell_y));
    const float wz = quintic(p.z() - static_cast<float>(cell_z));
    const auto x0 = static_cast<std::uint32_t>(cell_x) * kPrimeX;
    const auto y0 = static_cast<std::uint32_t>(cell_y) * kPrimeY;
    const auto z0 = static_cast<std::uint32_t>(cell_z) * kPrimeZ;
    const std::uint32_t x1 = x0 + kPrimeX;
    const std::uint32_t y1 = y0 + kPrimeY;
    const std::uint32_t z1 = z0 + kPrimeZ;
    const auto row = [&](std::uint32_t y, std::uint32_t z) -> Eigen::Array4f {
        const Eigen::Array4f& a = values_[slot(x0, y, z)];
        return a + wx * (values_[slot(x1, y, z)] - a);
    };
    const Eigen::Array4f y0z0 = row(y0, z0);
    const Eigen::Array4f y0z1 = row(y0, z1);
    const Eigen::Array4f near_z = y0z0 + wy * (row(y1, z0) - y0z0);
    const Eigen::Array4f far_z = y0z1 + wy * (row(y1, z1) - y0z1);
    return near_z + wz * (far_z - near_z);
}

Eigen::Array4f NoiseField::fractal(const Eigen::Vector3f& p,
                                   float wavelength_m,
                                   int num_octaves) const {
    Eigen::Array4f sum = Eigen::Array4f::Zero();
    Eigen::Vector3f q = p / wavelength_m;
    float weight = 1.0F;
    for (int i = 0; i < num_octaves; ++i) {
        sum += weight * at(q);
        weight *= 0.5F;
        q = next_octave(q);
    }
    return sum;
}

}  // namespace divemesh::simulator
