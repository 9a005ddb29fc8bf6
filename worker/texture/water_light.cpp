#include "worker/texture/water_light.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/base/parallel.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::texture {
namespace {

constexpr std::size_t kMaxSamples = 10'000;  // triangles
constexpr int kNumRounds = 10;
constexpr float kDark = 8.0F;  // grey levels of noise and veil, so that black is not minus infinity

LogColor log_color(const Candidate& candidate) {
    const LogColor levels(static_cast<float>(candidate.bgr[0]),
                          static_cast<float>(candidate.bgr[1]),
                          static_cast<float>(candidate.bgr[2]));
    return (levels + kDark).log();
}

// Returns triangles with enough candidates, in equal steps through the mesh.
std::vector<std::size_t> sampled_faces(const FaceCandidates& candidates) {
    std::vector<std::size_t> faces;
    for (std::size_t face = 0; face < candidates.num_faces(); ++face)
        if (candidates.of(face).size() >= kMinJudgedViews) faces.push_back(face);
    const std::size_t step = 1 + faces.size() / kMaxSamples;
    std::vector<std::size_t> sampled;
    for (std::size_t i = 0; i < faces.size(); i += step) sampled.push_back(faces[i]);
    return sampled;
}

// The residuals of a sampled triangle, with how much farther than the median each keyframe is.
struct Sample {
    std::span<const Candidate> candidates;
    ColorResiduals residuals;
    std::array<float, FaceCandidates::kMaxViews> beyond_m = {};
};

Sample sample_of(const SeenMesh& seen, const WaterLight& light, std::size_t face) {
    Sample sample{seen.candidates.of(face), color_residuals(seen, light, face)};
    std::vector<double> ranges_m;
    for (const Candidate& candidate : sample.candidates)
        ranges_m.push_back(static_cast<double>(seen.range_m(face, candidate)));
    const double median_m = stats::median(ranges_m);
    for (std::size_t i = 0; i < ranges_m.size(); ++i)
        sample.beyond_m[i] = static_cast<float>(ranges_m[i] - median_m);
    return sample;
}

std::vector<Sample> samples_of(const SeenMesh& seen,
                               const WaterLight& light,
                               const std::vector<std::size_t>& faces,
                               int num_threads) {
    std::vector<Sample> samples(faces.size());
    base::for_each_index(num_threads, faces.size(), [&](std::size_t i) {
        samples[i] = sample_of(seen, light, faces[i]);
    });
    return samples;
}

// Calls visit(candidate, residual, beyond_m) for each candidate of the samples.
template <typename Visit>
void for_each_residual(const std::vector<Sample>& samples, const Visit& visit) {
    for (const Sample& sample : samples)
        for (std::size_t i = 0; i < sample.candidates.size(); ++i)
            visit(sample.candidates[i], sample.residuals[i], sample.beyond_m[i]);
}

// Returns the slope of a line through the origin with the smallest sum of absolute residuals: the
// weighted median of the ratios (Laplace's method of situation).
float slope_by_least_absolute(std::vector<std::pair<float, float>>& ratios_and_weights) {
    std::sort(ratios_and_weights.begin(), ratios_and_weights.end());
    double left = 0.0;
    for (const auto& [ratio, weight] : ratios_and_weights) left += static_cast<double>(weight);
    left *= 0.5;
    for (const auto& [ratio, weight] : ratios_and_weights) {
        left -= static_cast<double>(weight);
        if (left <= 0.0) return ratio;
    }
    return 0.0F;
}

LogColor fall_with_range_per_m(const std::vector<Sample>& samples) {
    LogColor slope;
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<std::pair<float, float>> ratios_and_weights;
        for_each_residual(samples, [&](const Candidate&, const LogColor& residual, float beyond_m) {
            if (beyond_m != 0.0F)
                ratios_and_weights.emplace_back(residual[channel] / beyond_m, std::abs(beyond_m));
        });
        slope[channel] = slope_by_least_absolute(ratios_and_weights);
    }
    return -slope;
}

std::vector<LogColor> gains_of(const std::vector<Sample>& samples, std::size_t num_views) {
    std::vector<LogColor> gains(num_views);
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<std::vector<double>> of_view(num_views);
        for_each_residual(
            samples, [&](const Candidate& candidate, const LogColor& residual, float) {
                of_view[candidate.view].push_back(static_cast<double>(residual[channel]));
            });
        for (std::size_t view = 0; view < num_views; ++view)
            gains[view][channel] = static_cast<float>(stats::median(std::move(of_view[view])));
    }
    return gains;
}

LogColor sigma_of(const std::vector<Sample>& samples) {
    LogColor sigma;
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<double> sizes;
        for_each_residual(samples, [&](const Candidate&, const LogColor& residual, float) {
            sizes.push_back(static_cast<double>(std::abs(residual[channel])));
        });
        sigma[channel] = static_cast<float>(stats::kSigmasPerMad * stats::median(std::move(sizes)));
    }
    return sigma;
}

}  // namespace

float SeenMesh::range_m(std::size_t face, const Candidate& candidate) const {
    const auto& [a, b, c] = mesh.triangles[face];
    const Eigen::Vector3f center_world =
        (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3.0F;
    return (keyframes[candidate.view].T_world_cam.translation().cast<float>() - center_world)
        .norm();
}

ColorResiduals color_residuals(const SeenMesh& seen, const WaterLight& light, std::size_t face) {
    const std::span<const Candidate> candidates = seen.candidates.of(face);
    ColorResiduals residuals;
    for (std::size_t i = 0; i < candidates.size(); ++i)
        residuals[i] = log_color(candidates[i]) - light.gains[candidates[i].view] +
                       light.attenuation_per_m * seen.range_m(face, candidates[i]);
    for (int channel = 0; channel < 3; ++channel) {
        std::vector<double> values;
        for (std::size_t i = 0; i < candidates.size(); ++i)
            values.push_back(static_cast<double>(residuals[i][channel]));
        const auto median = static_cast<float>(stats::median(std::move(values)));
        for (std::size_t i = 0; i < candidates.size(); ++i) residuals[i][channel] -= median;
    }
    return residuals;
}

WaterLight fit_water_light(const SeenMesh& seen, int num_threads) {
    WaterLight light;
    light.gains.assign(seen.keyframes.size(), LogColor::Zero());
    const std::vector<std::size_t> faces = sampled_faces(seen.candidates);
    for (int round = 0; round < kNumRounds; ++round) {
        light.attenuation_per_m +=
            fall_with_range_per_m(samples_of(seen, light, faces, num_threads));
        const std::vector<LogColor> gains =
            gains_of(samples_of(seen, light, faces, num_threads), light.gains.size());
        for (std::size_t view = 0; view < gains.size(); ++view) light.gains[view] += gains[view];
    }
    light.sigma = sigma_of(samples_of(seen, light, faces, num_threads));
    return light;
}

}  // namespace divemesh::texture
