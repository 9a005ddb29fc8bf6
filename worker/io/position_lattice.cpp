#include "worker/io/position_lattice.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace divemesh::io {
namespace {

constexpr int kMinBits = 14;
constexpr int kMaxBits = 16;
constexpr double kErrorInSigma = 0.1;

// Returns 0 if no sigma is known.
double smallest_sigma_m(const types::Mesh& mesh) {
    float smallest_m = 0.0F;
    for (const float sigma_m : mesh.sigma_m)
        if (sigma_m > 0.0F && (smallest_m == 0.0F || sigma_m < smallest_m)) smallest_m = sigma_m;
    return smallest_m;
}

}  // namespace

std::array<std::uint16_t, 3> PositionLattice::nearest(const Eigen::Vector3f& p_world) const {
    std::array<std::uint16_t, 3> steps{};
    for (Eigen::Index i = 0; i < 3; ++i)
        steps[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(
            std::clamp(std::round((p_world[i] - low_m[i]) / step_m), 0.0, 65535.0));
    return steps;
}

double PositionLattice::max_error_m() const { return 0.5 * std::sqrt(3.0) * step_m; }

PositionLattice position_lattice(const types::Mesh& mesh) {
    PositionLattice lattice;
    if (mesh.vertices.empty()) return lattice;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex.cast<double>());
    lattice.low_m = box.min();
    const double extent_m = box.sizes().maxCoeff();
    if (extent_m == 0.0) return lattice;
    const double max_error_m = kErrorInSigma * smallest_sigma_m(mesh);
    for (int bits = kMinBits; bits <= kMaxBits; ++bits) {
        lattice.step_m = extent_m / ((1 << bits) - 1);
        if (lattice.max_error_m() <= max_error_m) break;
    }
    return lattice;
}

}  // namespace divemesh::io
