#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "worker/base/background_task.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/marker_plan.hpp"
#include "worker/evaluation/combined_scale.hpp"
#include "worker/evaluation/evaluation.hpp"
#include "worker/keyframes/keyframe_store.hpp"
#include "worker/markers/locate_markers.hpp"
#include "worker/markers/marker_metrics.hpp"
#include "worker/markers/world_scale.hpp"
#include "worker/mesh/image_coverage.hpp"
#include "worker/mesh/mesh_borders.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/pipeline/stage_time.hpp"
#include "worker/types/georeference.hpp"
#include "worker/types/rig_alignment.hpp"

namespace divemesh::pipeline {

// The state of a running reconstruction: what its stages share in memory. The rest is in the
// scratch folder.
struct Reconstruction {
    // Opens the dive, removes an earlier result from the folder of the artifacts and creates the
    // folder. Throws Error{BadData} with the first error among the findings, Error{InvalidArgument}
    // if the scale correction was requested but is not possible.
    explicit Reconstruction(const ReconstructionRequest& made_for);

    // Has all later stages use this rig instead of the stated one.
    void set_rig(const types::Rig& rig);

    // Has all later stages read images at 1 / `reduction` of their size.
    void set_reduction(int reduction);

    // Returns the refined calibration, and the rig that the poses belong to: refined, and scaled
    // once the scale was corrected. Both are of images as recorded.
    types::RefinedCalibration refined() const;
    types::Rig used_rig() const;

    // Returns where the world's origin lies: as estimated, else as dive.json states it.
    std::optional<types::GeographicPosition> position() const;

    const ReconstructionOptions& options() const { return known_options; }
    // Returns true once an error is among the findings on the track: no surface can follow.
    bool has_failed() const { return has_error(optimised.findings); }
    std::filesystem::path artifact(const std::string& name) const { return request.out / name; }
    std::filesystem::path scratch(const std::string& name) const { return request.scratch / name; }

    const ReconstructionRequest& request;
    // Those that the stage that runs may read, see options_known_to(); before the first stage and
    // after the last all of them.
    ReconstructionOptions known_options;
    std::unique_ptr<dive::Dive> opened_dive;
    dive::Dive& dive;
    AlignedRecording recording;  // the dive with the rig that all stages after align use
    std::optional<dive::MarkerPlan> marker_plan;  // nullopt: markers are not searched for

    // align
    types::RigAlignment alignment;

    // track
    keyframes::KeyframeStore keyframe_store;  // after optimise: rectified with the refined lenses
    // After optimise: without the data that only optimise reads.
    types::Track track;

    // optimise; after markers: with the corrected scale
    types::OptimisedTrack optimised;
    std::shared_ptr<const camera::ShutterCorrection> shutter;  // null: none is rolling
    std::int64_t num_landmarks = 0;

    // markers
    std::optional<markers::MarkerMetrics> markers;
    std::optional<markers::WorldScale> scale;  // as applied
    // Why it was applied; nullopt: it was not, or it was asked for.
    std::optional<evaluation::CombinedScale> scale_correction;
    // Scale of the current result by positions from outside; nullopt: there are none.
    std::optional<evaluation::ScaleCheck> scale_by_positions;
    std::optional<types::GeoReference> georeference;  // nullopt: nothing outside was measured

    // fuse
    std::unique_ptr<fusion::Volume> volume;  // until the mesh is extracted
    VoxelSizes voxels;
    double max_depth_m = 0.0;  // of what was fused
    std::int64_t volume_memory_bytes = 0;
    CloudMetrics cloud;

    // mesh
    Surface surface;
    // These two are valid after border_finder.wait(), which texture calls.
    mesh::MeshBorders borders;
    std::vector<mesh::ImageCoverage> coverage;

    // color
    std::optional<WaterColor> color;  // nullopt: colours stay as recorded, as asked

    // texture
    TextureMetrics texture;
    std::string thumbnail_png;

    // evaluate
    evaluation::Evaluation evaluation;

    std::vector<StageTime> stages;  // finished stages

    // Background tasks: the cloud is written during meshing, the mesh while its images are made,
    // and its borders and coverage are found meanwhile. Declared last, so that they end before the
    // data that they read is destroyed.
    base::TaskPool task_pool;
    base::BackgroundTask cloud_writer{task_pool};
    base::BackgroundTask mesh_writer{task_pool};
    base::BackgroundTask border_finder{task_pool};
};

}  // namespace divemesh::pipeline
