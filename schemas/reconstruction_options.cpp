#include "schemas/reconstruction_options.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>
#include <type_traits>

#include "schemas/error.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/option_range.hpp"

namespace divemesh {
namespace {

// Visits every option once, with the values it may have and its text. Its JSON key is its field
// name.
template <typename Options, typename Visit>
void for_each_option(Options& options, Visit&& visit) {
    // clang-format off
    visit("align_cameras", options.align_cameras, OptionRange{}, "estimate the right camera's pose relative to the left one from the images, and the medium of the calibration, and use them where they differ from what is stated");
    visit("stereo", options.stereo, OptionRange{.words = {"block", "sgm", "opencv_sgbm"}}, "stereo matcher: block (sum of absolute differences, the paper), sgm or opencv_sgbm");
    visit("num_disparities_px", options.num_disparities_px, OptionRange{.min = 16, .max = 512, .multiple_of = 16}, "disparity search range in px of the images as reduced, a multiple of 16; features and sgm search images wider than 832 px farther");
    visit("stereo_scales", options.stereo_scales, OptionRange{.min = 1, .max = 2}, "image sizes at which sgm matches: 1 the full size, 2 also half of it (weak texture, haze)");
    visit("num_features", options.num_features, OptionRange{.min = 20, .max = 5000}, "features tracked per frame");
    visit("max_width_px", options.max_width_px, OptionRange{.min = 160, .zero = "no limit"}, "images that are wider are reconstructed at a half, a third, ... of their size; 0: at full size");
    visit("estimator", options.estimator, OptionRange{.words = {"pairwise", "window"}}, "pairwise (the paper) or window (sliding window)");
    visit("use_imu", options.use_imu, OptionRange{}, "use the IMU if the dive has one");
    visit("use_ahrs", options.use_ahrs, OptionRange{}, "use the absolute orientation if the dive has it");
    visit("use_pressure", options.use_pressure, OptionRange{}, "use the depth from the pressure sensor if the dive has it");
    visit("align_imu", options.align_imu, OptionRange{}, "estimate time offset and rotation between IMU and cameras (sliding window)");
    visit("close_loops", options.close_loops, OptionRange{}, "recognise revisited places and use them in the bundle adjustment");
    visit("surface", options.surface, OptionRange{}, "make the cloud, the mesh and what depends on them; false: only the trajectory");
    visit("map_step", options.map_step, OptionRange{.min = 0, .max = 1, .zero = "only keyframes"}, "motion of the image between fused frames, as a share of its width, or of the camera as if sideways; 0: only keyframes");
    visit("seed", options.seed, OptionRange{}, "seed of the random numbers of RANSAC");
    visit("adjust_whole_dive", options.adjust_whole_dive, OptionRange{}, "run bundle adjustment over the whole dive (sliding window)");
    visit("refine_lenses", options.refine_lenses, OptionRange{}, "refine focal length, principal point, distortion and the readout time of a rolling shutter in the bundle adjustment (sliding window)");
    visit("marker_family", options.marker_family, OptionRange{.words = {"", "tag36h11", "tag25h9", "tagStandard41h12"}}, "family of AprilTags to detect: tag36h11, tag25h9, tagStandard41h12; empty: from markers.json");
    visit("marker_size_m", options.marker_size_m, OptionRange{.min = 0.005, .max = 10, .zero = "from markers.json"}, "printed size of the tags, m, as defined in docs/markers.md; 0: from markers.json");
    visit("correct_scale", options.correct_scale, OptionRange{.words = {"auto", "on", "off"}}, "scale of the whole result: on (by the known distances between markers), off, or auto (where known distances, accelerometer or pressure measure it better than the cameras, or contradict them)");
    visit("fusion", options.fusion, OptionRange{.words = {"octree", "tsdf"}}, "octree (points, the paper) or tsdf");
    visit("mesher", options.mesher, OptionRange{.words = {"surface_nets", "marching_cubes"}}, "surface_nets or marching_cubes");
    visit("voxel_m", options.voxel_m, OptionRange{.min = 0.0005, .max = 1, .zero = "automatic"}, "edge of all voxels, m; 0: chosen locally from rig and range");
    visit("max_depth_m", options.max_depth_m, OptionRange{.min = 0.05, .max = 100, .zero = "automatic"}, "max depth that is fused, m; 0: from the rig. Less where segments of the dive would meet");
    visit("cloud_spacing_m", options.cloud_spacing_m, OptionRange{.min = 0.0005, .max = 1, .zero = "half a voxel"}, "distance between the points of the cloud, m; 0: half a voxel");
    visit("across_frames", options.across_frames, OptionRange{.words = {"off", "refine", "fill"}}, "depth by the frames around, whose baselines are longer: off, refine (what pairs measured) or fill (every pixel, and what pairs could not measure)");
    visit("max_sigma_m", options.max_sigma_m, OptionRange{.min = 0.0001, .max = 10, .zero = "no limit"}, "max standard deviation of a vertex, m; less certain surface is removed, before what contradicts the scale is added; 0: no limit");
    visit("simplify", options.simplify, OptionRange{.min = 0, .max = 1, .above_min = true}, "share of the triangles to keep, 0 to 1; 1: all of them");
    visit("simplify_error_m", options.simplify_error_m, OptionRange{.min = 0, .max = 1, .zero = "no limit"}, "quadric error at which simplification stops, m; 0: no limit");
    visit("color", options.color, OptionRange{.words = {"raw", "restored"}}, "colours of mesh.ply, mesh.glb and the mosaic: raw (as recorded) or restored (without attenuation and backscatter of the water, as far as the dive tells them)");
    visit("white_point", options.white_point, OptionRange{}, "color.white_point in metrics.json of an earlier dive of the place, three numbers with commas, so that restored colours compare; empty: from the dive");
    visit("texture", options.texture, OptionRange{}, "texture mesh.glb with the photographs, and make the mosaic");
    visit("exports", options.exports, OptionRange{.words = {"kitti", "euroc", "obj", "ply", "colmap", "nerfstudio", "las", "laz", "e57", "3dtiles", "mcap"}, .is_list = true}, "files for other programs, separated by commas: kitti, euroc (trajectory), obj, ply, las, laz, 3dtiles (mesh), e57 (points), colmap, nerfstudio, mcap (keyframes)");
    visit("num_threads", options.num_threads, OptionRange{.min = 0, .max = 1024, .zero = "all cores"}, "0: all cores; the result does not depend on it");
    visit("fusion_memory_bytes", options.fusion_memory_bytes, OptionRange{.min = 64 << 20}, "max memory for voxels and points, the rest goes to the scratch folder; the result does not depend on it");
    // clang-format on
}

// Collects what is wrong with the options, by name.
class OptionFaults {
public:
    void add(const std::string& name, const std::string& rule) {
        const auto pointer = nlohmann::json::json_pointer() / name;
        faults_.push_back({"option " + name + " " + rule, pointer.to_string(), ""});
    }
    void require(bool ok, const std::string& name, const std::string& rule) {
        if (!ok) add(name, rule);
    }
    void require_word(const std::string& name, const std::string& word, const OptionRange& range) {
        std::string list;
        for (const auto known : range.words) list.append(list.empty() ? "" : ", ").append(known);
        require(range.allows(word), name, "is \"" + word + "\"; it must be one of: " + list);
    }
    void refuse() const {
        if (!faults_.empty()) throw InvalidInput(faults_);
    }

private:
    std::vector<Fault> faults_;
};

void validate_words(const std::string& name,
                    const std::string& text,
                    const OptionRange& range,
                    OptionFaults& faults) {
    if (!range.is_list) return faults.require_word(name, text, range);
    for (std::size_t start = 0; start < text.size();) {
        const std::size_t end = std::min(text.find(',', start), text.size());
        faults.require_word(name, text.substr(start, end - start), range);
        start = end + 1;
    }
}

template <typename Value>
void validate_value(const std::string& name,
                    const Value& value,
                    const OptionRange& range,
                    OptionFaults& faults) {
    if constexpr (std::is_same_v<Value, std::string>)
        validate_words(name, value, range, faults);
    else if constexpr (!std::is_same_v<Value, bool>)
        faults.require(
            range.allows(static_cast<double>(value)), name, range.rule(unit_in_name(name)));
}

void validate_exports(const ReconstructionOptions& options, OptionFaults& faults) {
    const std::string& list = options.exports;
    for (std::size_t start = 0; start < list.size();) {
        const std::size_t end = std::min(list.find(',', start), list.size());
        const std::string word = list.substr(start, end - start);
        faults.require(word == "kitti" || word == "euroc" || options.surface,
                       "exports",
                       "has " + word + ", which needs surface=true");
        start = end + 1;
    }
}

// Checks each option by its row of the table, then what depends on more than one.
void validate(const ReconstructionOptions& options, OptionFaults& faults) {
    for_each_option(
        options, [&](const char* name, const auto& value, const OptionRange& range, const char*) {
            validate_value(name, value, range, faults);
        });
    validate_exports(options, faults);
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
}

template <typename Value>
const char* type_of() {
    if constexpr (std::is_same_v<Value, bool>) return "boolean";
    if constexpr (std::is_same_v<Value, std::string>) return "string";
    return std::is_floating_point_v<Value> ? "number" : "integer";
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
    for_each_option(options, [&](const char* name, auto& value, const OptionRange&, const char*) {
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
                    [&](const char* name, const auto& value, const OptionRange&, const char*) {
                        json[name] = value;
                    });
    return json;
}

std::vector<OptionText> explain(const ReconstructionOptions& options) {
    std::vector<OptionText> rows;
    for_each_option(
        options, [&](const char* name, const auto& value, const OptionRange&, const char* text) {
            const nlohmann::json json = value;
            rows.push_back({name, json.is_string() ? json.get<std::string>() : json.dump(), text});
        });
    return rows;
}

nlohmann::json describe_options() {
    nlohmann::json options = nlohmann::json::array();
    const ReconstructionOptions any;
    for_each_option(
        any, [&](const char* name, const auto& value, const OptionRange& range, const char* text) {
            nlohmann::json option = range_to_json(range);
            option["name"] = name;
            option["type"] = type_of<std::decay_t<decltype(value)>>();
            option["unit"] = unit_in_name(name);
            option["help"] = text;
            options.push_back(std::move(option));
        });
    for (const std::string_view preset : kPresets) {
        const nlohmann::json defaults = options_to_json(preset_options(preset));
        for (nlohmann::json& option : options)
            option["defaults"][std::string(preset)] =
                defaults.at(option["name"].get_ref<const std::string&>());
    }
    return options;
}

}  // namespace divemesh
