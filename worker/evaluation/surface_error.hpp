#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "worker/evaluation/seen_in_pairs.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::evaluation {

// How two surfaces are compared.
struct SurfaceErrorInput {
    Eigen::Isometry3d T_reference_world = Eigen::Isometry3d::Identity();  // from the poses
    std::vector<Eigen::Vector3d>
        camera_positions_world;        // of the estimate; empty: no limit of range
    std::optional<StereoPairs> pairs;  // of the estimate; nullopt: no share of what they saw
    // All true surface that a camera saw, in the reference's world; nullptr: the reference is all
    // that is known. Our surface is compared with it, the reference with ours.
    const types::Mesh* scene = nullptr;
    double near_range_m = 1.6;  // reference surface within this range counts as near
    double max_range_m = 4.0;   // our surface farther than this from every camera is left out
    std::int64_t num_samples = 1'000'000;  // in each direction
    std::uint64_t seed = 1;
    int num_threads = 0;  // 0: all cores; does not change any metric
};

// Distances in one direction: from samples on one surface to the nearest point of the other.
struct DistanceSummary {
    std::int64_t num_samples = 0;
    double median_m = 0.0;
    double mean_m = 0.0;
    double rms_m = 0.0;
    double p90_m = 0.0;
};

// Precision: share of our surface within the threshold of the reference; recall: share of the
// reference within the threshold of our surface; F1: their harmonic mean (Knapitsch et al. 2017).
struct ThresholdScore {
    double threshold_m = 0.0;
    double precision = 0.0;
    double recall = 0.0;
    double f1 = 0.0;
};

// Distance to the reference divided by the distance to the nearest camera, as the paper states
// errors.
struct RelativeDistance {
    double median = 0.0;
    double p80 = 0.0;
};

// The distances between our surface and the reference, in both directions.
struct SurfaceError {
    DistanceSummary accuracy;      // ours -> scene
    DistanceSummary completeness;  // reference -> ours, over the whole reference
    // The next two are nullopt if the cameras are unknown.
    std::optional<RelativeDistance> relative;          // of accuracy
    std::optional<DistanceSummary> near_completeness;  // of the reference near a camera
    // Share of the reference seen in three pairs within kSeenRange_m that lies within 20 mm of our
    // surface; nullopt if the pairs are unknown, nothing was seen, or the reference is a cloud.
    std::optional<double> share_20mm;
    double false_share_50mm = 0.0;       // of all our samples: farther from the scene
    double share_beyond_range = 0.0;     // of our samples; these are excluded from accuracy
    std::vector<ThresholdScore> scores;  // 5, 10, 20, 50 mm
    // Median distance from a reference point to the next; only if the reference is a cloud.
    std::optional<double> reference_spacing_m;
    // Share of our samples in bins of kErrorBin_m; the last bin holds all larger errors. Not in
    // to_metrics().
    std::vector<double> histogram;
};

inline constexpr double kSeenRange_m = 3.0;
inline constexpr double kErrorBin_m = 0.001;
inline constexpr std::size_t kNumErrorBins = 51;

// Returns the error of our mesh relative to the reference mesh, without ICP: our mesh is only moved
// by T_reference_world. Samples are uniform over the area; distances are to the nearest point of
// the nearest triangle. A reference without triangles is a cloud: distances are to its nearest
// point, and its points are the samples. Throws Error{BadData} if a mesh has no area or the
// reference is empty.
SurfaceError surface_error(const types::Mesh& mesh_world,
                           const types::Mesh& reference,
                           const SurfaceErrorInput& input);

nlohmann::json to_metrics(const SurfaceError& error);

}  // namespace divemesh::evaluation
