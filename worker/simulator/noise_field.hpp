#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace divemesh::simulator {

// Solid noise (Perlin 1985; here value noise with quintic weights): four independent smooth
// functions of a point, each in [-1, 1].
class NoiseField {
public:
    explicit NoiseField(std::uint64_t seed);

    // Returns the four values; features are about one unit wide.
    Eigen::Array4f at(const Eigen::Vector3f& p) const;
    // Returns the sum of octaves from `wavelength_m` downwards, each half as strong as the one
    // before.
    Eigen::Array4f fractal(const Eigen::Vector3f& p, float wavelength_m, int num_octaves) const;

private:
    std::vector<Eigen::Array4f> values_;
};

constexpr float kOctaveRatio = 1.93F;

// Rotates and scales a point from one octave to the next, so that their lattices never line up: a
// rotation by 1.1 rad about (1, 2, 3), times kOctaveRatio.
inline Eigen::Vector3f next_octave(const Eigen::Vector3f& p) {
    return {0.950766F * p.x() - 1.228441F * p.y() + 1.145372F * p.z() + 17.3F,
            1.529744F * p.x() + 1.176743F * p.y() - 0.007743F * p.z() + 5.7F,
            -0.693418F * p.x() + 0.911651F * p.y() + 1.553372F * p.z() + 11.9F};
}

// Returns the share of a pattern of this wavelength that remains when a pixel covers `footprint_m`:
// what would alias is faded out.
inline float band_limit(float wavelength_m, float footprint_m) {
    const float x = (wavelength_m / footprint_m - 1.3F) / 1.7F;
    const float c = x < 0.0F ? 0.0F : (x > 1.0F ? 1.0F : x);
    return c * c * (3.0F - 2.0F * c);
}

}  // namespace divemesh::simulator
