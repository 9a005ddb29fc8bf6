#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// Noise as a surface from stereo has it: vertices that one window of pixels measured err together.
// A normal number at every place, of variance 1, whose correlation falls to 1/e over
// `correlation_length_m`: white noise on a lattice, spread by quadratic B-splines and divided by
// the root of the squared weights. Depends on seed and place alone.
class NoiseField {
public:
    NoiseField(double correlation_length_m, std::uint64_t seed);
    double at(const Eigen::Vector3d& place) const;

private:
    double per_m_;  // lattice nodes
    std::uint64_t seed_;
};

// The vertices moved along their normals by scale * sigma * noise, with a sigma for each.
std::vector<Eigen::Vector3d> with_noise(const SurfacePatch& patch,
                                        const std::vector<double>& sigma_m,
                                        const NoiseField& noise,
                                        double scale);

}  // namespace divemesh::reef
