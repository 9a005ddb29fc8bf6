#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/reconstruction_options.hpp"
#include "worker/evaluation/combined_scale.hpp"
#include "worker/evaluation/evaluation.hpp"
#include "worker/evaluation/expected_accuracy.hpp"
#include "worker/evaluation/imu_check.hpp"
#include "worker/markers/marker_metrics.hpp"
#include "worker/mesh/image_coverage.hpp"
#include "worker/mesh/mesh_borders.hpp"
#include "worker/mesh/simplify_mesh.hpp"
#include "worker/pipeline/map_metrics.hpp"
#include "worker/pipeline/stage_time.hpp"
#include "worker/pipeline/texture_metrics.hpp"
#include "worker/pipeline/water_color.hpp"
#include "worker/types/geographic_position.hpp"
#include "worker/types/georeference.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/rig_alignment.hpp"
#include "worker/types/track.hpp"
#include "worker/types/tracking_segment.hpp"

namespace divemesh::pipeline {

// Metrics of the mesh and of what it was made from.
struct MeshMetrics {
    std::int64_t num_vertices = 0;
    std::int64_t num_triangles = 0;
    double area_m2 = 0.0;
    mesh::MeshBorders borders;
    std::vector<mesh::ImageCoverage> coverage;
    double small_components_m2 = 0.0;  // these two were removed
    double cut_by_sigma_m2 = 0.0;
    std::optional<mesh::SimplificationError> simplification;  // nullopt: not simplified
    VoxelSizes voxels;
    CloudMetrics cloud;
    std::int64_t volume_memory_bytes = 0;
};

// Everything that metrics.json is made from.
struct MetricsInput {
    std::string version;
    std::string preset;
    ReconstructionOptions options;  // as used in this run
    std::string dive_name;
    std::optional<types::GeographicPosition> position;
    std::optional<types::GeoReference> georeference = std::nullopt;
    std::string content_sha256;
    double duration_s = 0.0;
    types::Rig stated_rig;
    types::Rig rig;       // as used: with the alignment, if it was applied
    types::Rig used_rig;  // the poses belong to it: refined and scaled too
    types::RigAlignment alignment;
    std::optional<evaluation::GravityCheck> gravity;  // nullopt: no IMU
    types::RefinedCalibration refined;
    std::optional<Eigen::Matrix3d> end_covariance_m2;  // of the last position; nullopt: unknown
    types::TrackStatistics track;
    std::int32_t reduction = 1;  // as in Track
    types::OptimiseStatistics optimise;
    std::int64_t num_keyframes = 0;
    std::int64_t num_landmarks = 0;
    std::int64_t num_frames_by_imu = 0;     // the IMU alone measured the motion to them
    std::int64_t num_frames_predicted = 0;  // nothing measured their pose
    double path_length_m = 0.0;             // of the final trajectory, over what was measured
    bool vertical_is_known = true;          // by sensors; false: z is up only if the first image is
    std::vector<types::TrackingSegment> segments;
    std::optional<MeshMetrics> mesh;                // nullopt: no surface was requested
    std::optional<TextureMetrics> texture;          // likewise
    const WaterColor* color = nullptr;              // null: colours stay as recorded, as asked
    std::optional<markers::MarkerMetrics> markers;  // nullopt: markers were not searched for
    std::optional<evaluation::CombinedScale> scale_correction;  // nullopt: not applied by itself
    std::vector<StageTime> stages;
    evaluation::Evaluation evaluation;
    std::optional<evaluation::ExpectedAccuracy> expected;
    std::vector<Finding> findings;  // of the dive; those of `evaluation` and `expected` are added
};

// Returns metrics.json as described by schemas/metrics.schema.json. Unknown values are left out.
nlohmann::json metrics_document(const MetricsInput& input);

// Returns the peak memory of this process so far.
std::int64_t peak_memory_bytes();

}  // namespace divemesh::pipeline
