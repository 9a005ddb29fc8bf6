#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// The options of a reconstruction. Each preset is a set of these; every field can be overridden by
// name (`--set name=value`, JSON in the API). One line per field in reconstruction_options.cpp is
// its text for --explain. Units end the name where they are not SI.
struct ReconstructionOptions {
    // step 1, stereo
    std::string stereo = "sgm";    // block (the paper) | sgm | opencv_sgbm
    int num_disparities_px = 128;  // search range, multiple of 16
    int stereo_scales = 2;         // 2: sgm matches at half the size too
    // step 2, tracking
    int num_features = 300;
    // steps 4-6, estimation
    std::string estimator = "window";  // pairwise (the paper) | window
    bool use_imu = true;
    bool use_ahrs = true;
    bool use_pressure = true;
    bool adjust_whole_dive = true;  // bundle adjustment of the whole dive
    bool close_loops = true;        // at revisited places; needs adjust_whole_dive
    bool align_imu = true;          // estimate its time offset and rotation against the cameras
    bool align_cameras = true;      // estimate the right camera's position before tracking
    bool refine_lenses = true;      // estimate focal length, principal point and distortion
    bool surface = true;            // false: the trajectory only, without steps 7 and 8
    // step 7, fusion
    std::string fusion = "tsdf";   // octree (the paper) | tsdf
    double map_step = 0.02;        // shift between fused frames / image width; 0: keyframes only
    double voxel_m = 0.0;          // 0: place by place, from rig and range
    double max_depth_m = 0.0;      // 0: chosen from the rig
    double cloud_spacing_m = 0.0;  // between the points of the cloud; 0: half a voxel
    // Limit for voxels and points in memory; more goes to the scratch folder. Never changes the
    // result.
    std::int64_t fusion_memory_bytes = std::int64_t{1} << 30;
    // step 8, surface
    std::string mesher = "surface_nets";  // surface_nets | marching_cubes
    double max_sigma_m = 0.0;             // of a vertex; vaguer surface is cut; 0: no limit
    double simplify = 1.0;                // share of the triangles to keep
    double simplify_error_m = 0;          // quadric error at which simplifying stops; 0: no limit
    bool texture = true;                  // the mosaic; there is no texture yet
    // markers in the scene; these override markers.json
    std::string marker_family;   // tag36h11 | tag25h9 | tagStandard41h12; empty: as the dive says
    double marker_size_m = 0.0;  // of all tags; 0: as the dive says
    // Scale of the whole result: on (by the markers' known distances), off, or auto (by all that
    // measures lengths, where it contradicts the cameras).
    std::string correct_scale = "auto";
    // formats of other programs to export besides our own, comma-separated: kitti, euroc, obj
    std::string exports;
    // machine
    int num_threads = 0;    // 0: all cores; never changes a byte of the result
    std::int64_t seed = 1;  // of RANSAC

    bool operator==(const ReconstructionOptions&) const = default;
};

inline constexpr std::string_view kPresets[] = {"paper", "fast", "standard", "accurate"};

// Returns the options of a preset. Throws Error{InvalidArgument}, which lists the presets.
ReconstructionOptions preset_options(std::string_view preset);

// Returns the preset with overrides, checked. Throws Error{InvalidArgument}, which names an unknown
// or impossible option.
ReconstructionOptions make_options(std::string_view preset, const nlohmann::json& overrides);

struct OptionText {
    std::string name;
    std::string value;
    std::string text;  // one line: what it does, unit
};
// Returns every option with its value and text, for --explain.
std::vector<OptionText> explain(const ReconstructionOptions& options);

nlohmann::json options_to_json(const ReconstructionOptions& options);

}  // namespace divemesh
