#include "worker/metrics/surface_error.hpp"

#include <algorithm>
#include <cmath>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "worker/metrics/surface_index.hpp"
#include "worker/metrics/surface_samples.hpp"

namespace divemesh::worker {
namespace {

constexpr double kThresholds_m[] = {0.005, 0.010, 0.020, 0.050};

Mesh moved(const Mesh& mesh_world, const Eigen::Isometry3d& T_reference_world) {
    Mesh mesh;
    mesh.triangles = mesh_world.triangles;
    mesh.vertices.reserve(mesh_world.vertices.size());
    for (const Eigen::Vector3f& vertex : mesh_world.vertices)
        mesh.vertices.emplace_back((T_reference_world * vertex.cast<double>()).cast<float>());
    return mesh;
}

// Neighbours in `samples` are neighbours in space, so the camera that served the last one is
// asked first.
std::vector<Eigen::Vector3f> within_range(const std::vector<Eigen::Vector3f>& samples,
                                          const SurfaceErrorInput& input) {
    if (input.camera_positions_world.empty()) return samples;
    std::vector<Eigen::Vector3f> cameras;
    for (const Eigen::Vector3d& camera : input.camera_positions_world)
        cameras.emplace_back((input.T_reference_world * camera).cast<float>());
    const auto limit = static_cast<float>(input.max_range_m * input.max_range_m);
    std::vector<Eigen::Vector3f> kept;
    kept.reserve(samples.size());
    std::size_t last = 0;
    for (const Eigen::Vector3f& sample : samples) {
        const auto sees = [&](const Eigen::Vector3f& camera) {
            return (camera - sample).squaredNorm() <= limit;
        };
        if (!sees(cameras[last])) {
            const auto found = std::find_if(cameras.begin(), cameras.end(), sees);
            if (found == cameras.end()) continue;
            last = static_cast<std::size_t>(found - cameras.begin());
        }
        kept.push_back(sample);
    }
    return kept;
}

std::vector<double> distances(const std::vector<Eigen::Vector3f>& samples,
                              const SurfaceIndex& surface,
                              int num_threads) {
    std::vector<double> result(samples.size());
    tbb::task_arena arena(num_threads > 0 ? num_threads : tbb::task_arena::automatic);
    arena.execute([&] {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples.size(), 4096),
                          [&](const tbb::blocked_range<std::size_t>& range) {
                              for (std::size_t i = range.begin(); i < range.end(); ++i)
                                  result[i] = static_cast<double>(surface.distance_m(samples[i]));
                          });
    });
    return result;
}

// Takes distances in rising order.
double quantile(const std::vector<double>& sorted, double share) {
    if (sorted.empty()) return 0.0;
    const double position = share * static_cast<double>(sorted.size() - 1);
    const auto index = static_cast<std::size_t>(position);
    const double rest = position - static_cast<double>(index);
    return sorted[index] + rest * (sorted[std::min(index + 1, sorted.size() - 1)] - sorted[index]);
}

DistanceSummary summarise(const std::vector<double>& sorted) {
    DistanceSummary summary;
    summary.num_samples = static_cast<std::int64_t>(sorted.size());
    if (sorted.empty()) return summary;
    double sum = 0.0;
    double squares = 0.0;
    for (const double distance : sorted) {
        sum += distance;
        squares += distance * distance;
    }
    const auto count = static_cast<double>(sorted.size());
    summary.mean_m = sum / count;
    summary.rms_m = std::sqrt(squares / count);
    summary.median_m = quantile(sorted, 0.5);
    summary.p90_m = quantile(sorted, 0.9);
    return summary;
}

double share_within(const std::vector<double>& sorted, double threshold) {
    if (sorted.empty()) return 0.0;
    const auto end = std::upper_bound(sorted.begin(), sorted.end(), threshold);
    return static_cast<double>(end - sorted.begin()) / static_cast<double>(sorted.size());
}

nlohmann::json to_json(const DistanceSummary& summary) {
    return {{"num_samples", summary.num_samples},
            {"median_m", summary.median_m},
            {"mean_m", summary.mean_m},
            {"rms_m", summary.rms_m},
            {"p90_m", summary.p90_m}};
}

}  // namespace

SurfaceError surface_error(const Mesh& mesh_world,
                           const Mesh& reference,
                           const SurfaceErrorInput& input) {
    const Mesh mesh = moved(mesh_world, input.T_reference_world);
    const auto all_samples = sample_surface(mesh, input.num_samples, input.seed);
    const auto our_samples = within_range(all_samples, input);
    auto accuracy = distances(our_samples, SurfaceIndex(reference), input.num_threads);
    auto completeness = distances(sample_surface(reference, input.num_samples, input.seed),
                                  SurfaceIndex(mesh),
                                  input.num_threads);
    std::sort(accuracy.begin(), accuracy.end());
    std::sort(completeness.begin(), completeness.end());

    SurfaceError error;
    error.accuracy = summarise(accuracy);
    error.completeness = summarise(completeness);
    error.share_beyond_range =
        1.0 - static_cast<double>(our_samples.size()) / static_cast<double>(all_samples.size());
    for (const double threshold : kThresholds_m) {
        const double precision = share_within(accuracy, threshold);
        const double recall = share_within(completeness, threshold);
        const double sum = precision + recall;
        error.scores.push_back(
            {threshold, precision, recall, sum > 0.0 ? 2.0 * precision * recall / sum : 0.0});
    }
    return error;
}

nlohmann::json to_metrics(const SurfaceError& error) {
    nlohmann::json scores = nlohmann::json::array();
    for (const ThresholdScore& score : error.scores)
        scores.push_back({{"threshold_m", score.threshold_m},
                          {"precision", score.precision},
                          {"recall", score.recall},
                          {"f1", score.f1}});
    return {{"accuracy", to_json(error.accuracy)},
            {"completeness", to_json(error.completeness)},
            {"share_beyond_range", error.share_beyond_range},
            {"scores", scores}};
}

}  // namespace divemesh::worker
