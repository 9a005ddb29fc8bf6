#include "worker/pipeline/stage_keys.hpp"

#include <nlohmann/json.hpp>

#include "schemas/content_hash.hpp"

namespace divemesh::pipeline {
namespace {

nlohmann::json take_out(nlohmann::json& options, const std::vector<std::string>& names) {
    nlohmann::json taken = nlohmann::json::object();
    for (const std::string& name : names) {
        taken[name] = options.at(name);
        options.erase(name);
    }
    return taken;
}

std::string chained(const std::string& before, const nlohmann::json& options) {
    return sha256_hex(before + "\n" + options.dump());
}

bool reads_count(const StageSpec& stage, const ReconstructionOptions& options) {
    return stage.reads_count == nullptr || stage.reads_count(options);
}

}  // namespace

StageKeys stage_keys(const std::vector<StageSpec>& stages,
                     const std::string& program,
                     const std::string& content_sha256,
                     const ReconstructionOptions& options) {
    nlohmann::json rest = options_to_json(options);
    for (const std::string_view name : kOptionsOfTheMachine) rest.erase(std::string(name));
    std::vector<nlohmann::json> read;
    for (const StageSpec& stage : stages) {
        read.push_back(take_out(rest, stage.reads));
        if (!reads_count(stage, options)) read.back().clear();
    }
    if (!read.empty()) read.front().update(rest);

    StageKeys keys;
    std::string key = program + "\n" + content_sha256;
    for (std::size_t i = 0; i < stages.size(); ++i) {
        key = chained(key, read[i]);
        keys[stages[i].name] = key;
    }
    return keys;
}

ReconstructionOptions options_known_to(std::size_t index,
                                       const std::vector<StageSpec>& stages,
                                       const ReconstructionOptions& options) {
    const nlohmann::json defaults = options_to_json({});
    nlohmann::json known = options_to_json(options);
    for (std::size_t later = index + 1; later < stages.size(); ++later)
        for (const std::string& name : stages[later].reads) known[name] = defaults.at(name);
    return make_options("standard", known);
}

}  // namespace divemesh::pipeline
