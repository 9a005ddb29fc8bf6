#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// What a person may tune. Each preset is a set of these; every field can be overridden by name
// (`--set name=value`, JSON in the API). One line per field in reconstruction_options.cpp gives
// its text for --explain. Units end the name where they are not SI.
struct ReconstructionOptions {
    // step 1, stereo
    std::string stereo = "sgm";    // block (the paper) | sgm | opencv_sgbm
    int num_disparities_px = 128;  // search range, multiple of 16
    // step 2, tracking
    int num_features = 300;
    // steps 4-6, estimation
    std::string estimator = "window";  // pairwise (the paper) | window
    bool use_imu = true;
    bool use_ahrs = true;
    bool use_pressure = true;
    bool adjust_whole_dive = true;  // with hindsight
    bool close_loops = true;        // places that the dive came to again; of the above
    bool align_imu = true;          // estimate its time offset and rotation against the cameras
    bool refine_lenses = true;      // estimate focal length, principal point and distortion
    bool surface = true;            // false: the trajectory alone, steps 7 and 8 left out
    // step 7, fusion
    std::string fusion = "tsdf";  // octree (the paper) | tsdf
    double map_step = 0.02;    // of the picture, between frames that are fused; 0: keyframes alone
    double voxel_m = 0.0;      // 0: chosen from rig and range
    double max_depth_m = 0.0;  // 0: chosen from the rig
    double cloud_spacing_m = 0.0;  // between the points of the cloud; 0: half a voxel
    // Of voxels and points in memory; more goes to the scratch folder. Never changes the result.
    std::int64_t fusion_memory_bytes = std::int64_t{1} << 30;
    // step 8, surface
    std::string mesher = "surface_nets";  // surface_nets | marching_cubes
    double simplify = 1.0;                // share of the triangles that stays
    double simplify_error_m = 0;          // quadric error that ends simplifying sooner; 0: no limit
    bool texture = true;                  // the mosaic; no texture is made yet
    // markers in the scene; what markers.json says of them, these say in its place
    std::string marker_family;   // tag36h11 | tag25h9 | tagStandard41h12; empty: as the dive says
    double marker_size_m = 0.0;  // of all tags; 0: as the dive says
    bool correct_scale = false;  // of the whole result, by the markers' known distances
    // other programs' formats beside our own, separated by commas: kitti, euroc, obj
    std::string exports;
    // machine
    int num_threads = 0;    // 0: all cores; never changes a byte of the result
    std::int64_t seed = 1;  // of RANSAC

    bool operator==(const ReconstructionOptions&) const = default;
};

inline constexpr std::string_view kPresets[] = {"paper", "fast", "standard", "accurate"};

// The options of a preset. Throws Error{InvalidArgument} that lists the presets.
ReconstructionOptions preset_options(std::string_view preset);

// The preset with overrides, checked. Throws Error{InvalidArgument} that names an unknown or
// impossible option.
ReconstructionOptions make_options(std::string_view preset, const nlohmann::json& overrides);

struct OptionText {
    std::string name;
    std::string value;
    std::string text;  // one line: what it does, unit
};
std::vector<OptionText> explain(const ReconstructionOptions& options);

nlohmann::json options_to_json(const ReconstructionOptions& options);

}  // namespace divemesh
