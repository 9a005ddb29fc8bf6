#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// The options of a reconstruction. Each preset is a set of these; every field can be overridden by
// name (`--set name=value`, JSON in the API). One line per field in reconstruction_options.cpp is
// its text for --explain. Units end the name where they are not SI.
struct ReconstructionOptions {
    // Each group is what one stage is the first to read
    // (worker/pipeline/reconstruction_stages.cpp).

    // align
    bool align_cameras = true;  // estimate the right camera's pose before tracking
    // track: steps 1 to 6
    std::string stereo = "sgm";        // block (the paper) | sgm | opencv_sgbm
    int num_disparities_px = 128;      // search range, multiple of 16
    int stereo_scales = 2;             // 2: sgm matches at half the size too
    int num_features = 300;            // tracked per frame
    int max_width_px = 2800;           // of the images; larger ones are reduced; 0: no limit
    std::string estimator = "window";  // pairwise (the paper) | window
    bool use_imu = true;
    bool use_ahrs = true;
    bool use_pressure = true;
    bool align_imu = true;    // estimate its time offset and rotation against the cameras
    bool close_loops = true;  // at revisited places; needs adjust_whole_dive
    bool surface = true;      // false: the trajectory only, without steps 7 and 8
    double map_step = 0.02;   // shift between fused frames / image width; 0: keyframes only
    std::int64_t seed = 1;    // of RANSAC
    // optimise
    bool adjust_whole_dive = true;  // bundle adjustment of the whole dive
    bool refine_lenses = true;      // estimate focal length, principal point, distortion, shutter
    // markers: the tags override markers.json
    std::string marker_family;   // tag36h11 | tag25h9 | tagStandard41h12; empty: as the dive says
    double marker_size_m = 0.0;  // of all tags; 0: as the dive says
    // Scale of the whole result: on (by the markers' known distances), off, or auto (by all that
    // measures lengths: known distances, accelerometer, pressure).
    std::string correct_scale = "auto";
    // fuse: step 7
    std::string fusion = "tsdf";          // octree (the paper) | tsdf
    std::string mesher = "surface_nets";  // of step 8: surface_nets | marching_cubes
    double voxel_m = 0.0;                 // 0: chosen locally from rig and range
    double max_depth_m = 0.0;             // 0: chosen from the rig
    double cloud_spacing_m = 0.0;         // between the points of the cloud; 0: half a voxel
    // Depth by the frames around: off, refine (what pairs measured), fill (what they did not too).
    std::string across_frames = "refine";
    // mesh: step 8
    double max_sigma_m = 0.0;     // of a vertex; less certain surface is removed; 0: no limit
    double simplify = 1.0;        // share of the triangles to keep
    double simplify_error_m = 0;  // quadric error at which simplifying stops; 0: no limit
    // color
    std::string color = "raw";  // raw (as recorded) | restored (without the water)
    std::string white_point;    // of an earlier dive: three numbers; empty: chosen from the dive
    // texture
    bool texture = true;  // of mesh.glb, and the mosaic
    // evaluate
    std::string exports;  // for other programs, comma-separated
    // machine: never changes a byte of the result
    int num_threads = 0;  // 0: all cores
    // Limit for voxels and points in memory; more goes to the scratch folder.
    std::int64_t fusion_memory_bytes = std::int64_t{1} << 30;

    bool operator==(const ReconstructionOptions&) const = default;
};

inline constexpr std::string_view kPresets[] = {"paper", "fast", "standard", "accurate"};

// Returns the options of a preset. Throws Error{InvalidArgument}, which lists the presets.
ReconstructionOptions preset_options(std::string_view preset);

// Returns the preset with overrides, checked. Throws Error{InvalidArgument}, which names an unknown
// or impossible option.
ReconstructionOptions make_options(std::string_view preset, const nlohmann::json& overrides);

// Returns the numbers of the option white_point (r g b); nullopt if it is empty or no such three.
std::optional<std::array<double, 3>> white_point_of(const ReconstructionOptions& options);

struct OptionText {
    std::string name;
    std::string value;
    std::string text;  // one line: what it does, unit
};
// Returns every option with its value and text, for --explain.
std::vector<OptionText> explain(const ReconstructionOptions& options);

nlohmann::json options_to_json(const ReconstructionOptions& options);

}  // namespace divemesh
