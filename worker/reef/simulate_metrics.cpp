#include "worker/reef/simulate_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/parallel.hpp"
#include "worker/reef/surface_noise.hpp"

namespace divemesh::reef {
namespace {

Places measured_places(const std::vector<SurfacePatch>& patches) {
    Places places;
    for (const SurfacePatch& patch : patches) places.push_back(patch.vertices);
    return places;
}

Places noisy_places(const std::vector<SurfacePatch>& patches,
                    const NoiseField& noise,
                    double scale) {
    Places places;
    for (const SurfacePatch& patch : patches)
        places.push_back(with_noise(patch, patch.sigma_local_m, noise, scale));
    return places;
}

// Returns the requested number, but limits the time to half a minute for a model of millions of
// vertices.
int num_replicates(const std::vector<SurfacePatch>& patches,
                   std::vector<double> SurfacePatch::*sigma_m,
                   const MeasureOptions& options) {
    constexpr std::size_t kMaxVertices = 6'000'000;
    constexpr int kMinReplicates = 6;
    std::size_t num_vertices = 1;
    bool has_noise = false;
    for (const SurfacePatch& patch : patches) {
        num_vertices += patch.vertices.size();
        has_noise = has_noise || typical_sigma_m(patch.*sigma_m).has_value();
    }
    if (!has_noise || options.num_replicates < 2) return 0;
    const auto affordable = static_cast<int>(kMaxVertices / num_vertices);
    return std::min(options.num_replicates, std::max(kMinReplicates, affordable));
}

std::vector<double> sharpened_metrics(const Evaluate& evaluate,
                                      const Places& places,
                                      std::vector<double> measured,
                                      bool has_blur) {
    if (!has_blur) return measured;
    const std::vector<double> blurred = evaluate(places, 1);
    const std::vector<double> blurred_twice = evaluate(places, 2);
    for (std::size_t k = 0; k < measured.size(); ++k)
        measured[k] = stats::sharpened(measured[k], blurred[k], blurred_twice[k]);
    return measured;
}

}  // namespace

std::vector<stats::Simulated> simulate_metrics(const std::vector<SurfacePatch>& patches,
                                               double correlation_length_m,
                                               bool has_blur,
                                               const MeasureOptions& options,
                                               const Evaluate& evaluate) {
    const Places places = measured_places(patches);
    const std::vector<double> measured = evaluate(places, 0);
    const std::vector<double> sharp = sharpened_metrics(evaluate, places, measured, has_blur);
    const int num = num_replicates(patches, &SurfacePatch::sigma_local_m, options);
    std::vector<std::vector<double>> noisy(2 * static_cast<std::size_t>(num));
    base::for_each_index(options.num_threads, noisy.size(), [&](std::size_t i) {
        const NoiseField noise(correlation_length_m, options.seed + i / 2);
        const double scale = i % 2 == 0 ? 1.0 : std::numbers::sqrt2;
        const Places moved = noisy_places(patches, noise, scale);
        noisy[i] = sharpened_metrics(evaluate, moved, evaluate(moved, 0), has_blur);
    });
    std::vector<stats::Simulated> metrics(measured.size());
    for (std::size_t k = 0; k < measured.size(); ++k) {
        metrics[k].measured = measured[k];
        metrics[k].sharp = sharp[k];
        for (std::size_t i = 0; i < noisy.size(); ++i)
            (i % 2 == 0 ? metrics[k].once : metrics[k].twice).push_back(noisy[i][k]);
    }
    return metrics;
}

std::vector<double> standard_deviations(const std::vector<std::vector<double>>& replicates) {
    if (replicates.empty()) return {};
    const auto num = static_cast<Eigen::Index>(replicates.size());
    std::vector<double> deviations;
    for (std::size_t k = 0; k < replicates[0].size(); ++k) {
        Eigen::ArrayXd values(num);
        for (Eigen::Index i = 0; i < num; ++i)
            values[i] = replicates[static_cast<std::size_t>(i)][k];
        const double variance =
            (values - values.mean()).square().sum() / (static_cast<double>(num) - 1.0);
        deviations.push_back(std::isfinite(variance) ? std::sqrt(variance) : 0.0);
    }
    return deviations;
}

std::vector<double> bend_deviations(
    const std::vector<SurfacePatch>& patches,
    double alike_m,
    const MeasureOptions& options,
    const std::function<std::vector<double>(const Places& vertices)>& evaluate) {
    const int num = num_replicates(patches, &SurfacePatch::sigma_bend_m, options);
    std::vector<std::vector<double>> bent(num);
    base::for_each_index(options.num_threads, bent.size(), [&](std::size_t i) {
        const NoiseField field(alike_m, ~(options.seed + i));
        Places places;
        for (const SurfacePatch& patch : patches)
            places.push_back(with_noise(patch, patch.sigma_bend_m, field, 1.0));
        bent[i] = evaluate(places);
    });
    return standard_deviations(bent);
}

}  // namespace divemesh::reef
