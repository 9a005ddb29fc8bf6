#include "cli/preset_options.hpp"

#include "schemas/error.hpp"

namespace divemesh::cli {

void add_preset_options(CLI::App& command, PresetOptions& options) {
    command.add_option("--preset", options.preset, "paper, fast, standard or accurate")
        ->capture_default_str();
    command
        .add_option("--set",
                    options.set,
                    "name=value: set one option of the preset; `reconstruct --explain` lists them")
        ->allow_extra_args(false);
}

nlohmann::json overrides_of(const std::vector<std::string>& set) {
    nlohmann::json overrides = nlohmann::json::object();
    for (const auto& text : set) {
        const std::size_t equals = text.find('=');
        if (equals == 0 || equals == std::string::npos)
            throw Error(ErrorCode::InvalidArgument,
                        "--set " + text + " is not an assignment: give name=value");
        const std::string value = text.substr(equals + 1);
        auto json = nlohmann::json::parse(value, nullptr, false);
        overrides[text.substr(0, equals)] = json.is_discarded() ? nlohmann::json(value) : json;
    }
    return overrides;
}

}  // namespace divemesh::cli
