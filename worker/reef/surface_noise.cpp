#include "worker/reef/surface_noise.hpp"

#include <array>
#include <cmath>

#include "worker/base/hashed_random.hpp"

namespace divemesh::reef {
namespace {

// The correlation is 0.394 one lattice step apart, and 1/e at this many steps.
constexpr double kCorrelationLength_steps = 1.04;

// Returns a number of variance 1: the sum of four uniform numbers (Irwin and Hall), of which 27 are
// summed again.
double normal_at(std::uint64_t seed, std::int64_t x, std::int64_t y, std::int64_t z) {
    std::uint64_t bits =
        base::hash64(seed ^ base::hash64(static_cast<std::uint64_t>(x) * 0xd6e8feb86659fd93ULL ^
                                         static_cast<std::uint64_t>(y) * 0xa0761d6478bd642fULL ^
                                         static_cast<std::uint64_t>(z) * 0xe7037ed1a0b428dbULL));
    double sum = 0.0;
    for (int i = 0; i < 4; ++i, bits >>= 16) sum += static_cast<double>(bits & 0xffffU);
    return (sum / 65535.0 - 2.0) * std::sqrt(3.0);
}

// Returns the weights of a quadratic B-spline for the node nearest to `place`, the one before and
// the one after.
std::array<double, 3> weights(double offset) {  // from the nearest, [-0.5, 0.5]
    return {0.5 * (0.5 - offset) * (0.5 - offset),
            0.75 - offset * offset,
            0.5 * (0.5 + offset) * (0.5 + offset)};
}

double squared(const std::array<double, 3>& w) { return w[0] * w[0] + w[1] * w[1] + w[2] * w[2]; }

}  // namespace

NoiseField::NoiseField(double correlation_length_m, std::uint64_t seed)
    : per_m_(kCorrelationLength_steps / correlation_length_m), seed_(base::hash64(seed)) {}

double NoiseField::at(const Eigen::Vector3d& place) const {
    const Eigen::Vector3d node = place * per_m_;
    const Eigen::Vector3d nearest = node.array().round();
    std::array<std::array<double, 3>, 3> w;
    for (int axis = 0; axis < 3; ++axis) w[axis] = weights(node[axis] - nearest[axis]);
    double sum = 0.0;
    for (int x = 0; x < 3; ++x)
        for (int y = 0; y < 3; ++y)
            for (int z = 0; z < 3; ++z)
                sum += w[0][x] * w[1][y] * w[2][z] *
                       normal_at(seed_,
                                 static_cast<std::int64_t>(nearest.x()) + x - 1,
                                 static_cast<std::int64_t>(nearest.y()) + y - 1,
                                 static_cast<std::int64_t>(nearest.z()) + z - 1);
    return sum / std::sqrt(squared(w[0]) * squared(w[1]) * squared(w[2]));
}

std::vector<Eigen::Vector3d> with_noise(const SurfacePatch& patch,
                                        const std::vector<double>& sigma_m,
                                        const NoiseField& noise,
                                        double scale) {
    std::vector<Eigen::Vector3d> vertices = patch.vertices;
    for (std::size_t i = 0; i < vertices.size(); ++i)
        vertices[i] += scale * sigma_m[i] * noise.at(patch.vertices[i]) * patch.normals[i];
    return vertices;
}

}  // namespace divemesh::reef
