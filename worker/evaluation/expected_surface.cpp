#include "worker/evaluation/expected_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

namespace divemesh::evaluation {
namespace {

constexpr double kLevel = 0.95;
// A bin of sigmas is at most a 16th of an octave wide: 4 bits of a float's fraction.
constexpr int kFractionBits = 23 - 4;
constexpr std::size_t kNumBins = std::size_t{1} << (31 - kFractionBits);

std::vector<float> areas_at_vertices(const types::Mesh& mesh) {
    std::vector<float> areas(mesh.vertices.size(), 0.0F);
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3f normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                           .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        const float third = normal.norm() / 6.0F;
        for (const std::uint32_t vertex : t) areas[vertex] += third;
    }
    return areas;
}

// The area as a function of sigma.
class SigmaHistogram {
public:
    void add(float sigma_m, double area) {
        bins_[std::bit_cast<std::uint32_t>(std::max(0.0F, sigma_m)) >> kFractionBits] += area;
    }
    // Returns the sigma below which the share `share` of the area `whole` lies.
    double quantile_m(double share, double whole) const {
        double below = 0.0;
        for (std::size_t bin = 0; bin < kNumBins; ++bin)
            if (bins_[bin] > 0.0 && (below += bins_[bin]) >= share * whole) return middle_m(bin);
        return 0.0;
    }
    // Returns the expected area with an error of at most `error_m`.
    double area_within(double error_m) const {
        double area = 0.0;
        for (std::size_t bin = 0; bin < kNumBins; ++bin)
            if (bins_[bin] > 0.0)
                area += bins_[bin] * std::erf(error_m / (std::numbers::sqrt2 * middle_m(bin)));
        return area;
    }

private:
    static double middle_m(std::size_t bin) {
        const auto bits = (static_cast<std::uint32_t>(bin) << kFractionBits) |
                          (std::uint32_t{1} << (kFractionBits - 1));
        return static_cast<double>(std::bit_cast<float>(bits));
    }

    std::vector<double> bins_ = std::vector<double>(kNumBins, 0.0);
};

double error_95_m(const SigmaHistogram& sigmas, double largest_m, double whole) {
    double below = 0.0;
    double above = 4.0 * largest_m;
    for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (below + above);
        (sigmas.area_within(middle) < kLevel * whole ? below : above) = middle;
    }
    return above;
}

}  // namespace

std::optional<ExpectedSurface> expected_surface(const types::Mesh& mesh) {
    if (mesh.sigma_m.empty()) return std::nullopt;
    const std::vector<float> areas = areas_at_vertices(mesh);
    SigmaHistogram sigmas, local_sigmas;
    std::array<double, 3> by_views{};
    double whole = 0.0;
    for (std::size_t i = 0; i < areas.size(); ++i) {
        const auto area = static_cast<double>(areas[i]);
        const std::uint32_t num_views =
            mesh.num_observations.empty() ? 1 : std::clamp(mesh.num_observations[i], 1U, 3U);
        by_views[num_views - 1] += area;
        sigmas.add(mesh.sigma_m[i], area);
        if (!mesh.sigma_local_m.empty()) local_sigmas.add(mesh.sigma_local_m[i], area);
        whole += area;
    }
    if (whole <= 0.0) return std::nullopt;
    const float largest_m = *std::max_element(mesh.sigma_m.begin(), mesh.sigma_m.end());
    return ExpectedSurface{by_views[0] / whole,
                           by_views[1] / whole,
                           by_views[2] / whole,
                           sigmas.quantile_m(0.5, whole),
                           sigmas.quantile_m(kLevel, whole),
                           mesh.sigma_local_m.empty()
                               ? std::optional<double>()
                               : std::optional(local_sigmas.quantile_m(0.5, whole)),
                           error_95_m(sigmas, static_cast<double>(largest_m), whole)};
}

nlohmann::json to_metrics(const ExpectedSurface& surface) {
    nlohmann::json json = {{"share_1_view", surface.share_1_view},
                           {"share_2_views", surface.share_2_views},
                           {"share_3_views_or_more", surface.share_3_views_or_more},
                           {"sigma_median_m", surface.sigma_median_m},
                           {"sigma_p95_m", surface.sigma_p95_m},
                           {"error_95_m", surface.error_95_m}};
    if (surface.sigma_local_median_m) json["sigma_local_median_m"] = *surface.sigma_local_median_m;
    return json;
}

}  // namespace divemesh::evaluation
