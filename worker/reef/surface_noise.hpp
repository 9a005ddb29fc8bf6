#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// Noise of a surface from stereo, where vertices measured by one window of pixels share their
// error. It gives a normal number of variance 1 at every place, whose correlation falls to 1/e over
// `correlation_length_m`: white noise on a lattice, spread by quadratic B-splines and divided by
// the root of the squared weights. It depends only on seed and place.
class NoiseField {
public:
    NoiseField(double correlation_length_m, std::uint64_t seed);
    double at(const Eigen::Vector3d& place) const;

private:
    double per_m_;  // lattice nodes per metre
    std::uint64_t seed_;
};

// Returns the vertices moved along their normals by scale * sigma * noise, with one sigma per
// vertex.
std::vector<Eigen::Vector3d> with_noise(const SurfacePatch& patch,
                                        const std::vector<double>& sigma_m,
                                        const NoiseField& noise,
                                        double scale);

}  // namespace divemesh::reef
