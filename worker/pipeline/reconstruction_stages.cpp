#include "worker/pipeline/reconstruction_stages.hpp"

#include "worker/pipeline/stage_functions.hpp"
#include "worker/pipeline/water_color.hpp"

namespace divemesh::pipeline {
namespace {

bool corrects_scale(const ReconstructionOptions& options) { return options.correct_scale != "off"; }

}  // namespace

// clang-format off
std::vector<Stage<Reconstruction>> reconstruction_stages() {
    return {
        {.spec = {.name = "align", .part_of = "track",
                  .reads = {"align_cameras"},
                  .files = {"align.stage"}},
         .load = load_align, .run = run_align, .save = save_align, .finish = finish_align},

        {.spec = {.name = "track", .share = 0.51,
                  .reads = {"stereo", "num_disparities_px", "stereo_scales", "num_features", "max_width_px", "estimator", "use_imu",
                            "use_ahrs", "use_pressure", "align_imu", "close_loops", "surface", "map_step", "seed"},
                  .files = {"track.stage", "keyframes"}},
         .load = load_track, .run = run_track, .save = save_track, .finish = finish_track},

        {.spec = {.name = "optimise", .share = 0.1,
                  .reads = {"adjust_whole_dive", "refine_lenses"},
                  .files = {"optimise.stage"}},
         .load = load_optimise, .run = run_optimise, .save = save_optimise, .finish = finish_optimise},

        {.spec = {.name = "markers", .part_of = "optimise",
                  .reads = {"correct_scale", "marker_family", "marker_size_m"},
                  .reads_count = corrects_scale},
         .wanted = markers_wanted, .run = run_markers},

        {.spec = {.name = "fuse", .share = 0.15,
                  .reads = {"fusion", "mesher", "voxel_m", "max_depth_m", "cloud_spacing_m", "across_frames"},
                  .files = {"volume.stage", "cloud.ply", "cloud.stage"}},
         .wanted = surface_wanted, .load = load_fuse, .run = run_fuse, .save = save_fuse, .finish = finish_fuse},

        {.spec = {.name = "mesh", .share = 0.08,
                  .reads = {"max_sigma_m", "simplify", "simplify_error_m"},
                  .files = {"mesh.stage"}},
         .wanted = surface_wanted, .load = load_mesh, .run = run_mesh, .save = save_mesh, .finish = finish_mesh},

        {.spec = {.name = "color", .part_of = "texture", .share = 0.04,
                  .reads = {"color", "white_point"},
                  .reads_count = restores_color,
                  .files = {"color.stage"}},
         .wanted = color_wanted, .load = load_color, .run = run_color, .save = save_color, .finish = finish_color},

        {.spec = {.name = "texture", .share = 0.05,
                  .reads = {"texture"},
                  .files = {"texture", "texture.stage"}},
         .wanted = surface_wanted, .load = load_texture, .run = run_texture, .save = save_texture, .finish = finish_texture},

        // `exports` is read after all stages, when the artifacts are there.
        {.spec = {.name = "evaluate", .share = 0.07, .reads = {"exports"}, .is_evaluation = true}, .run = run_evaluate},
    };
}
// clang-format on

}  // namespace divemesh::pipeline
