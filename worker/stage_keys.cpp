#include "worker/stage_keys.hpp"

#include <initializer_list>

#include "schemas/content_hash.hpp"

namespace divemesh::worker {
namespace {

// The options that a stage is the first to read. One that is named nowhere counts as read by track:
// forgotten here, a new option costs time, never a wrong result.
constexpr std::initializer_list<const char*> kOptimiseReads = {"adjust_whole_dive",
                                                               "refine_lenses"};
constexpr std::initializer_list<const char*> kFuseReads = {
    "fusion", "voxel_m", "max_depth_m", "cloud_spacing_m"};
constexpr std::initializer_list<const char*> kMeshReads = {
    "mesher", "simplify", "simplify_error_m"};
constexpr std::initializer_list<const char*> kTextureReads = {"texture"};
// Read between optimise and fuse; fuse reads them through the scale that they lead to.
constexpr std::initializer_list<const char*> kScaleReads = {
    "correct_scale", "marker_family", "marker_size_m"};
// Change no byte of what stages make.
constexpr std::initializer_list<const char*> kNobodyReads = {
    "num_threads", "fusion_memory_bytes", "exports"};

nlohmann::json take_out(nlohmann::json& options, std::initializer_list<const char*> names) {
    nlohmann::json taken = nlohmann::json::object();
    for (const char* name : names) {
        taken[name] = options.at(name);
        options.erase(name);
    }
    return taken;
}

std::string chained(const std::string& before, const nlohmann::json& options) {
    return sha256_hex(before + "\n" + options.dump());
}

}  // namespace

StageKeys stage_keys(const std::string& program,
                     const std::string& content_sha256,
                     const ReconstructionOptions& options) {
    nlohmann::json rest = options_to_json(options);
    take_out(rest, kNobodyReads);
    const auto optimise = take_out(rest, kOptimiseReads);
    auto fuse = take_out(rest, kFuseReads);
    const auto scale = take_out(rest, kScaleReads);
    if (options.correct_scale) fuse["scale"] = scale;
    const auto mesh = take_out(rest, kMeshReads);
    const auto texture = take_out(rest, kTextureReads);
    StageKeys keys;
    keys.track = chained(program + "\n" + content_sha256, rest);
    keys.optimise = chained(keys.track, optimise);
    keys.fuse = chained(keys.optimise, fuse);
    keys.mesh = chained(keys.fuse, mesh);
    keys.texture = chained(keys.mesh, texture);
    return keys;
}

}  // namespace divemesh::worker
