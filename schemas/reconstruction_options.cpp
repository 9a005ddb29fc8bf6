#include "schemas/reconstruction_options.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>

#include "schemas/error.hpp"
#include "schemas/invalid_input.hpp"

namespace divemesh {
namespace {

// Visits every option once: its JSON key is its field name.
template <typename Options, typename Visit>
void for_each_option(Options& options, Visit&& visit) {
    // clang-format off
    visit("align_cameras", options.align_cameras, "estimate the right camera's pose relative to the left one from the images, and the medium of the calibration, and use them where they differ from what is stated");
    visit("stereo", options.stereo, "stereo matcher: block (sum of absolute differences, the paper), sgm or opencv_sgbm");
    visit("num_disparities_px", options.num_disparities_px, "disparity search range in px of the images as reduced, a multiple of 16; features and sgm search images wider than 832 px farther");
    visit("stereo_scales", options.stereo_scales, "image sizes at which sgm matches: 1 the full size, 2 also half of it (weak texture, haze)");
    visit("num_features", options.num_features, "features tracked per frame");
    visit("max_width_px", options.max_width_px, "images that are wider are reconstructed at a half, a third, ... of their size; 0: at full size");
    visit("estimator", options.estimator, "pairwise (the paper) or window (sliding window)");
    visit("use_imu", options.use_imu, "use the IMU if the dive has one");
    visit("use_ahrs", options.use_ahrs, "use the absolute orientation if the dive has it");
    visit("use_pressure", options.use_pressure, "use the depth from the pressure sensor if the dive has it");
    visit("align_imu", options.align_imu, "estimate time offset and rotation between IMU and cameras (sliding window)");
    visit("close_loops", options.close_loops, "recognise revisited places and use them in the bundle adjustment");
    visit("surface", options.surface, "make the cloud, the mesh and what depends on them; false: only the trajectory");
    visit("map_step", options.map_step, "motion of the image between fused frames, as a share of its width, or of the camera as if sideways; 0: only keyframes");
    visit("seed", options.seed, "seed of the random numbers of RANSAC");
    visit("adjust_whole_dive", options.adjust_whole_dive, "run bundle adjustment over the whole dive (sliding window)");
    visit("refine_lenses", options.refine_lenses, "refine focal length, principal point, distortion and the readout time of a rolling shutter in the bundle adjustment (sliding window)");
    visit("marker_family", options.marker_family, "family of AprilTags to detect: tag36h11, tag25h9, tagStandard41h12; empty: from markers.json");
    visit("marker_size_m", options.marker_size_m, "printed size of the tags, m, as defined in docs/markers.md; 0: from markers.json");
    visit("correct_scale", options.correct_scale, "scale of the whole result: on (by the known distances between markers), off, or auto (where known distances, accelerometer or pressure measure it better than the cameras, or contradict them)");
    visit("fusion", options.fusion, "octree (points, the paper) or tsdf");
    visit("mesher", options.mesher, "surface_nets or marching_cubes");
    visit("voxel_m", options.voxel_m, "edge of all voxels, m; 0: chosen locally from rig and range");
    visit("max_depth_m", options.max_depth_m, "max depth that is fused, m; 0: from the rig. Less where segments of the dive would meet");
    visit("cloud_spacing_m", options.cloud_spacing_m, "distance between the points of the cloud, m; 0: half a voxel");
    visit("across_frames", options.across_frames, "depth by the frames around, whose baselines are longer: off, refine (what pairs measured) or fill (every pixel, and what pairs could not measure)");
    visit("max_sigma_m", options.max_sigma_m, "max standard deviation of a vertex, m; less certain surface is removed, before what contradicts the scale is added; 0: no limit");
    visit("simplify", options.simplify, "share of the triangles to keep, 0 to 1; 1: all of them");
    visit("simplify_error_m", options.simplify_error_m, "quadric error at which simplification stops, m; 0: no limit");
    visit("color", options.color, "colours of mesh.ply, mesh.glb and the mosaic: raw (as recorded) or restored (without attenuation and backscatter of the water, as far as the dive tells them)");
    visit("white_point", options.white_point, "color.white_point in metrics.json of an earlier dive of the place, three numbers with commas, so that restored colours compare; empty: from the dive");
    visit("texture", options.texture, "texture mesh.glb with the photographs, and make the mosaic");
    visit("exports", options.exports, "files for other programs, separated by commas: kitti, euroc (trajectory), obj, ply, las, laz, 3dtiles (mesh), e57 (points), colmap, nerfstudio, mcap (keyframes)");
    visit("num_threads", options.num_threads, "0: all cores; the result does not depend on it");
    visit("fusion_memory_bytes", options.fusion_memory_bytes, "max memory for voxels and points, the rest goes to the scratch folder; the result does not depend on it");
    // clang-format on
}

// Collects what is wrong with the options, by name.
class OptionFaults {
public:
    void add(const std::string& name, const std::string& rule) {
        faults_.push_back({"option " + name + " " + rule, "/" + name, ""});
    }
    void require(bool ok, const std::string& name, const std::string& rule) {
        if (!ok) add(name, rule);
    }
    void require_one_of(const std::string& name,
                        const std::string& value,
                        std::initializer_list<std::string_view> known) {
        std::string list;
        for (const auto word : known) list.append(list.empty() ? "" : ", ").append(word);
        require(std::find(known.begin(), known.end(), value) != known.end(),
                name,
                "is \"" + value + "\"; it must be one of: " + list);
    }
    void refuse() const {
        if (!faults_.empty()) throw InvalidInput(faults_);
    }

private:
    std::vector<Fault> faults_;
};

void validate_exports(const ReconstructionOptions& options, OptionFaults& faults) {
    const std::string& list = options.exports;
    for (std::size_t start = 0; start < list.size();) {
        const std::size_t end = std::min(list.find(',', start), list.size());
        const std::string word = list.substr(start, end - start);
        faults.require_one_of("exports",
                              word,
                              {"kitti",
                               "euroc",
                               "obj",
                               "ply",
                               "colmap",
                               "nerfstudio",
                               "las",
                               "laz",
                               "e57",
                               "3dtiles",
                               "mcap"});
        faults.require(word == "kitti" || word == "euroc" || options.surface,
                       "exports",
                       "has " + word + ", which needs surface=true");
        start = end + 1;
    }
}

void validate(const ReconstructionOptions& options, OptionFaults& faults) {
    validate_exports(options, faults);
    faults.require_one_of("stereo", options.stereo, {"block", "sgm", "opencv_sgbm"});
    faults.require_one_of("estimator", options.estimator, {"pairwise", "window"});
    faults.require_one_of("fusion", options.fusion, {"octree", "tsdf"});
    faults.require_one_of("correct_scale", options.correct_scale, {"auto", "on", "off"});
    faults.require_one_of("across_frames", options.across_frames, {"off", "refine", "fill"});
    faults.require_one_of("color", options.color, {"raw", "restored"});
    faults.require(options.white_point.empty() || white_point_of(options).has_value(),
                   "white_point",
                   "must be empty (from the dive) or three numbers from 0.01 to 1000, such as "
                   "1.9,2.1,2.4");
    faults.require(!white_point_of(options) || options.color != "raw",
                   "white_point",
                   "has no effect on raw colours: give color=restored too");
    faults.require(options.color != "restored" || options.surface,
                   "color",
                   "needs surface=true to restore colours");
    faults.require_one_of("mesher", options.mesher, {"surface_nets", "marching_cubes"});
    faults.require(options.num_disparities_px >= 16 && options.num_disparities_px <= 512 &&
                       options.num_disparities_px % 16 == 0,
                   "num_disparities_px",
                   "must be a multiple of 16 from 16 to 512");
    faults.require(options.stereo_scales == 1 || options.stereo_scales == 2,
                   "stereo_scales",
                   "must be 1 or 2");
    faults.require(options.max_width_px == 0 || options.max_width_px >= 160,
                   "max_width_px",
                   "must be 0 (no limit) or at least 160");
    faults.require(options.num_features >= 20 && options.num_features <= 5000,
                   "num_features",
                   "must be 20 to 5000");
    faults.require(options.voxel_m == 0.0 || (options.voxel_m >= 0.0005 && options.voxel_m <= 1.0),
                   "voxel_m",
                   "must be 0 (automatic) or 0.0005 to 1 m");
    faults.require(
        options.max_depth_m == 0.0 || (options.max_depth_m >= 0.05 && options.max_depth_m <= 100.0),
        "max_depth_m",
        "must be 0 (automatic) or 0.05 to 100 m");
    faults.require(options.cloud_spacing_m == 0.0 ||
                       (options.cloud_spacing_m >= 0.0005 && options.cloud_spacing_m <= 1.0),
                   "cloud_spacing_m",
                   "must be 0 (half a voxel) or 0.0005 to 1 m");
    faults.require(options.fusion_memory_bytes >= std::int64_t{64} << 20,
                   "fusion_memory_bytes",
                   "must be at least 67108864 (64 MiB)");
    faults.require(options.map_step >= 0.0 && options.map_step <= 1.0,
                   "map_step",
                   "must be 0 (only keyframes) to 1, a share of the image width");
    faults.require(options.max_sigma_m == 0.0 ||
                       (options.max_sigma_m >= 0.0001 && options.max_sigma_m <= 10.0),
                   "max_sigma_m",
                   "must be 0 (no limit) or 0.0001 to 10 m");
    faults.require(options.simplify > 0.0 && options.simplify <= 1.0,
                   "simplify",
                   "must be more than 0 and at most 1 (all triangles)");
    faults.require(options.simplify_error_m >= 0.0 && options.simplify_error_m <= 1.0,
                   "simplify_error_m",
                   "must be 0 (no limit) to 1 m");
    faults.require_one_of(
        "marker_family", options.marker_family, {"", "tag36h11", "tag25h9", "tagStandard41h12"});
    faults.require(options.marker_size_m == 0.0 ||
                       (options.marker_size_m >= 0.005 && options.marker_size_m <= 10.0),
                   "marker_size_m",
                   "must be 0 (from markers.json) or 0.005 to 10 m");
    faults.require(options.num_threads >= 0 && options.num_threads <= 1024,
                   "num_threads",
                   "must be 0 (all cores) to 1024");
}

}  // namespace

std::optional<std::array<double, 3>> white_point_of(const ReconstructionOptions& options) {
    std::array<double, 3> numbers{};
    const char* next = options.white_point.data();
    const char* const end = next + options.white_point.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (i > 0 && (next == end || *next++ != ',')) return std::nullopt;
        const auto read = std::from_chars(next, end, numbers[i]);
        if (read.ec != std::errc() || !(numbers[i] >= 0.01 && numbers[i] <= 1000.0))
            return std::nullopt;
        next = read.ptr;
    }
    return next == end ? std::optional(numbers) : std::nullopt;
}

ReconstructionOptions preset_options(std::string_view preset) {
    ReconstructionOptions options;
    if (preset == "standard") return options;
    if (preset == "paper") {
        options.stereo = "block";
        options.estimator = "pairwise";
        options.correct_scale = "off";
        options.align_cameras = false;
        options.adjust_whole_dive = false;
        options.close_loops = false;
        options.fusion = "octree";
        options.across_frames = "off";
        return options;
    }
    if (preset == "fast") {  // a preview on the day of the dive: calibration as stated, no loops
        options.stereo_scales = 1;
        options.across_frames = "off";
        options.num_features = 200;
        options.close_loops = false;
        options.refine_lenses = false;
        options.map_step = 0.0;
        return options;
    }
    if (preset == "accurate") {
        options.num_features = 500;
        options.map_step = 0.01;
        options.across_frames = "fill";
        return options;
    }
    throw Error(
        ErrorCode::InvalidArgument,
        "unknown preset: " + std::string(preset) + " (known: paper, fast, standard, accurate)");
}

ReconstructionOptions make_options(std::string_view preset, const nlohmann::json& overrides) {
    ReconstructionOptions options = preset_options(preset);
    if (!overrides.is_object()) throw InvalidInput({{"options must be a JSON object", "", ""}});
    OptionFaults faults;
    nlohmann::json rest = overrides;
    // It was a switch once.
    if (const auto scale = rest.find("correct_scale"); scale != rest.end() && scale->is_boolean())
        *scale = scale->get<bool>() ? "on" : "off";
    for_each_option(options, [&](const char* name, auto& value, const char*) {
        const auto found = rest.find(name);
        if (found == rest.end()) return;
        try {
            found->get_to(value);
        } catch (const nlohmann::json::exception&) {
            faults.add(name, "has the wrong type: " + found->dump());
        }
        rest.erase(found);
    });
    for (const auto& [name, value] : rest.items()) faults.add(name, "is unknown");
    validate(options, faults);
    faults.refuse();
    return options;
}

nlohmann::json options_to_json(const ReconstructionOptions& options) {
    nlohmann::json json = nlohmann::json::object();
    for_each_option(options,
                    [&](const char* name, const auto& value, const char*) { json[name] = value; });
    return json;
}

std::vector<OptionText> explain(const ReconstructionOptions& options) {
    std::vector<OptionText> rows;
    for_each_option(options, [&](const char* name, const auto& value, const char* text) {
        const nlohmann::json json = value;
        rows.push_back({name, json.is_string() ? json.get<std::string>() : json.dump(), text});
    });
    return rows;
}

}  // namespace divemesh
