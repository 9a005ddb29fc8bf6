#include "worker/evaluation/surface_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "schemas/error.hpp"
#include "worker/base/parallel.hpp"
#include "worker/evaluation/nearest_camera.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/evaluation/surface_samples.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::evaluation {
namespace {

constexpr double kThresholds_m[] = {0.005, 0.010, 0.020, 0.050};
constexpr double kFound_m = 0.020;
constexpr double kFalse_m = 0.050;
constexpr int kMinPairs = 3;
constexpr std::size_t kMaxSeenSamples = 50'000;  // sigma of a share: 0.2 %

types::Mesh moved(const types::Mesh& mesh_world, const Eigen::Isometry3d& T_reference_world) {
    types::Mesh mesh;
    mesh.triangles = mesh_world.triangles;
    mesh.vertices.reserve(mesh_world.vertices.size());
    for (const Eigen::Vector3f& vertex : mesh_world.vertices)
        mesh.vertices.emplace_back((T_reference_world * vertex.cast<double>()).cast<float>());
    return mesh;
}

NearestCamera cameras_of(const SurfaceErrorInput& input) {
    std::vector<Eigen::Vector3f> cameras;
    for (const Eigen::Vector3d& camera : input.camera_positions_world)
        cameras.emplace_back((input.T_reference_world * camera).cast<float>());
    return NearestCamera(std::move(cameras));
}

// Returns the range of each sample from the nearest camera, in order.
std::vector<double> ranges(const std::vector<Eigen::Vector3f>& samples,
                           const NearestCamera& cameras,
                           int num_threads) {
    std::vector<double> ranges_m(samples.size());
    base::for_each_index(num_threads, samples.size(), [&](std::size_t i) {
        ranges_m[i] = static_cast<double>(cameras.distance_m(samples[i]));
    });
    return ranges_m;
}

// Returns the entries with a range of at most `limit_m`.
template <typename T>
std::vector<T> within(const std::vector<T>& entries,
                      const std::vector<double>& ranges_m,
                      double limit_m) {
    std::vector<T> kept;
    kept.reserve(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (ranges_m[i] <= limit_m) kept.push_back(entries[i]);
    return kept;
}

// Returns the number of samples that are farther than kFalse_m from the reference.
template <typename Surface>
std::int64_t count_false(const std::vector<Eigen::Vector3f>& samples,
                         const Surface& reference,
                         int num_threads) {
    constexpr auto kLimit_m = static_cast<float>(kFalse_m);
    std::vector<std::uint8_t> is_false(samples.size());
    base::for_each_index(num_threads, samples.size(), [&](std::size_t i) {
        is_false[i] = reference.distance_m(samples[i], kLimit_m) >= kLimit_m ? 1 : 0;
    });
    return std::count(is_false.begin(), is_false.end(), 1);
}

// Returns the share within kFound_m of our surface of the reference samples that the pairs saw;
// nullopt if they saw none.
std::optional<double> share_of_seen(const std::vector<Eigen::Vector3f>& reference_samples,
                                    const std::vector<double>& completeness_m,
                                    const SeenInPairs& pairs,
                                    int num_threads) {
    const std::size_t step = 1 + reference_samples.size() / (kMaxSeenSamples + 1);
    std::vector<std::uint8_t> seen((reference_samples.size() + step - 1) / step);
    base::for_each_index(num_threads, seen.size(), [&](std::size_t i) {
        seen[i] = pairs.is_seen(reference_samples[i * step], kMinPairs) ? 1 : 0;
    });
    std::int64_t num_seen = 0;
    std::int64_t num_found = 0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        num_seen += seen[i];
        num_found += completeness_m[i * step] <= kFound_m ? seen[i] : 0;
    }
    if (num_seen == 0) return std::nullopt;
    return static_cast<double>(num_found) / static_cast<double>(num_seen);
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
    summary.median_m = stats::quantile_of_sorted(sorted, 0.5);
    summary.p90_m = stats::quantile_of_sorted(sorted, 0.9);
    return summary;
}

RelativeDistance relative_to(const std::vector<double>& ranges_m,
                             const std::vector<double>& distances_m) {
    std::vector<double> ratios(distances_m.size());
    for (std::size_t i = 0; i < ratios.size(); ++i) ratios[i] = distances_m[i] / ranges_m[i];
    std::sort(ratios.begin(), ratios.end());
    return {stats::quantile_of_sorted(ratios, 0.5), stats::quantile_of_sorted(ratios, 0.8)};
}

// Returns points of the cloud at equal steps of their order, at most as many as samples of a mesh.
std::vector<Eigen::Vector3f> sample_points(const types::Mesh& cloud, std::int64_t num_samples) {
    const auto step =
        std::max<std::size_t>(1,
                              (cloud.vertices.size() + static_cast<std::size_t>(num_samples) - 1) /
                                  static_cast<std::size_t>(num_samples));
    std::vector<Eigen::Vector3f> samples;
    for (std::size_t i = 0; i < cloud.vertices.size(); i += step)
        samples.push_back(cloud.vertices[i]);
    return samples;
}

// Compares with every other point; points at the same position count as one.
double spacing_m(const types::Mesh& cloud, int num_threads) {
    constexpr std::size_t kNumSamples = 256;
    const std::size_t step = std::max<std::size_t>(1, cloud.vertices.size() / kNumSamples);
    std::vector<double> nearest_m((cloud.vertices.size() + step - 1) / step);
    base::for_each_index(num_threads, nearest_m.size(), [&](std::size_t i) {
        float nearest = std::numeric_limits<float>::infinity();
        for (const Eigen::Vector3f& other : cloud.vertices) {
            const float squared = (other - cloud.vertices[i * step]).squaredNorm();
            if (squared > 0.0F) nearest = std::min(nearest, squared);
        }
        nearest_m[i] = std::sqrt(static_cast<double>(nearest));
    });
    return stats::median(std::move(nearest_m));
}

std::vector<double> histogram_of(const std::vector<double>& distances_m) {
    std::vector<double> shares(kNumErrorBins, 0.0);
    for (const double distance : distances_m)
        shares[std::min(static_cast<std::size_t>(distance / kErrorBin_m), kNumErrorBins - 1)] +=
            1.0 / static_cast<double>(distances_m.size());
    return shares;
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

SurfaceError surface_error(const types::Mesh& mesh_world,
                           const types::Mesh& reference,
                           const SurfaceErrorInput& input) {
    if (reference.vertices.empty())
        throw Error(ErrorCode::BadData,
                    "the reference has neither triangles nor points: check the file");
    const bool is_cloud = reference.triangles.empty();
    const types::Mesh mesh = moved(mesh_world, input.T_reference_world);
    const auto reference_samples = is_cloud
                                       ? sample_points(reference, input.num_samples)
                                       : sample_surface(reference, input.num_samples, input.seed);
    auto completeness = SurfaceIndex(mesh).distances_m(reference_samples, input.num_threads);
    auto our_samples = sample_surface(mesh, input.num_samples, input.seed);
    const auto num_samples = static_cast<double>(our_samples.size());

    SurfaceError error;
    std::vector<double> our_ranges_m;
    std::vector<Eigen::Vector3f> beyond_range;
    if (!input.camera_positions_world.empty()) {
        const NearestCamera cameras = cameras_of(input);
        const auto ranges_m = ranges(our_samples, cameras, input.num_threads);
        for (std::size_t i = 0; i < our_samples.size(); ++i)
            if (ranges_m[i] > input.max_range_m) beyond_range.push_back(our_samples[i]);
        our_samples = within(our_samples, ranges_m, input.max_range_m);
        our_ranges_m = within(ranges_m, ranges_m, input.max_range_m);
        auto near = within(completeness,
                           ranges(reference_samples, cameras, input.num_threads),
                           input.near_range_m);
        std::sort(near.begin(), near.end());
        error.near_completeness = summarise(near);
    }
    std::int64_t num_false = 0;
    const auto compare = [&](const auto& surface) {
        num_false = count_false(beyond_range, surface, input.num_threads);
        return surface.distances_m(our_samples, input.num_threads);
    };
    std::vector<double> accuracy;
    if (is_cloud && input.scene == nullptr) {
        accuracy = compare(PointIndex(reference));
    } else {
        const SurfaceIndex surface(input.scene != nullptr ? *input.scene : reference);
        accuracy = compare(surface);
        if (input.pairs && !is_cloud)
            error.share_20mm = share_of_seen(
                reference_samples,
                completeness,
                SeenInPairs(*input.pairs, input.T_reference_world, surface, kSeenRange_m),
                input.num_threads);
    }
    if (is_cloud) error.reference_spacing_m = spacing_m(reference, input.num_threads);
    error.histogram = histogram_of(accuracy);
    if (!our_ranges_m.empty()) error.relative = relative_to(our_ranges_m, accuracy);
    std::sort(accuracy.begin(), accuracy.end());
    std::sort(completeness.begin(), completeness.end());

    error.accuracy = summarise(accuracy);
    error.completeness = summarise(completeness);
    num_false += accuracy.end() - std::upper_bound(accuracy.begin(), accuracy.end(), kFalse_m);
    error.false_share_50mm = static_cast<double>(num_false) / num_samples;
    error.share_beyond_range = 1.0 - static_cast<double>(our_samples.size()) / num_samples;
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
    nlohmann::json json = {{"accuracy", to_json(error.accuracy)},
                           {"completeness", to_json(error.completeness)},
                           {"share_beyond_range", error.share_beyond_range},
                           {"false_share_50mm", error.false_share_50mm},
                           {"scores", scores}};
    if (error.relative)
        json["relative_accuracy"] = {{"median_percent", 100.0 * error.relative->median},
                                     {"p80_percent", 100.0 * error.relative->p80}};
    if (error.share_20mm) json["share_20mm"] = *error.share_20mm;
    if (error.reference_spacing_m) json["reference_spacing_m"] = *error.reference_spacing_m;
    if (error.near_completeness) json["near_completeness"] = to_json(*error.near_completeness);
    return json;
}

}  // namespace divemesh::evaluation
