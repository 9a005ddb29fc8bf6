#include <array>
#include <cstdio>
#include <iostream>
#include <memory>
#include <sstream>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/server_options.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"

namespace divemesh::cli {
namespace {

namespace client = api::client;

struct DivesOptions {
    ServerOptions server;
    std::string dive_id;
    std::string site;
    std::string state;
    int newest = 0;                     // 0: all, the oldest first
    std::vector<std::string> edits;     // name=value
    std::vector<std::string> recorded;  // names
};

int list_dives(client::RestClient& rest, const DivesOptions& options, const Context& context) {
    client::QueryParameters query;
    if (!options.site.empty()) query.emplace_back("site", options.site);
    if (!options.state.empty())
        query.emplace_back("state", to_string(dive_state_from_string(options.state)));
    const auto items = listed(rest, "/api/v1/dives", query, options.newest);
    if (context.json) {
        std::cout << nlohmann::json(items).dump(2) << '\n';
        return kExitDone;
    }
    std::vector<std::vector<std::string>> rows = {
        {"ID", "NAME", "SITE", "STATE", "FRAMES", "LENGTH", "SIZE", "CREATED"}};
    for (const auto& item : items) {
        const Dive dive = item.get<Dive>();
        rows.push_back({dive.id,
                        dive.name,
                        dive.site,
                        std::string(to_string(dive.state)),
                        std::to_string(dive.num_frames),
                        duration_text(dive.duration_s),
                        bytes_text(static_cast<double>(dive.archive_bytes)),
                        time_text(dive.created_at_ms)});
    }
    std::cout << table_text(rows);
    return kExitDone;
}

std::string truth_text(const TruthFile& file) {
    return std::string(to_string(file.kind)) + ' ' + file.id + ": " + file.name + ", " +
           bytes_text(static_cast<double>(file.size_bytes)) + ", sent " +
           time_text(file.created_at_ms) +
           (file.problem.empty() ? "" : "; not used, it cannot be read: " + file.problem) + '\n';
}

// Returns {"latitude_deg": ..., "longitude_deg": ...} of "54.1,8.2".
nlohmann::json parse_position(const std::string& text) {
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
    int end = 0;
    if (std::sscanf(text.c_str(), "%lf,%lf%n", &latitude_deg, &longitude_deg, &end) != 2 ||
        static_cast<std::size_t>(end) != text.size())
        throw Error(ErrorCode::InvalidArgument,
                    "--edit position=" + text + ": write latitude,longitude in degrees: 54.1,-8.2");
    return {{"latitude_deg", latitude_deg}, {"longitude_deg", longitude_deg}};
}

nlohmann::json parse_tags(const std::string& text) {
    nlohmann::json tags = nlohmann::json::array();
    std::istringstream list(text);
    for (std::string tag; std::getline(list, tag, ',');) tags.push_back(tag);
    return tags;
}

// Returns the merge patch of --edit and --recorded.
nlohmann::json edit_of(const DivesOptions& options) {
    nlohmann::json patch = nlohmann::json::object();
    for (const std::string& edit : options.edits) {
        const auto equals = edit.find('=');
        if (equals == std::string::npos)
            throw Error(ErrorCode::InvalidArgument, "--edit " + edit + ": write field=value");
        const std::string name = edit.substr(0, equals);
        const std::string value = edit.substr(equals + 1);
        if (name == "position")
            patch[name] = parse_position(value);
        else if (name == "tags")
            patch[name] = parse_tags(value);
        else
            patch[name] = value;
    }
    for (const std::string& name : options.recorded) patch[name] = nullptr;
    return patch;
}

int show_dive(client::RestClient& rest, const DivesOptions& options, const Context& context) {
    const std::string path = client::dive_path(options.dive_id);
    const nlohmann::json edit = edit_of(options);
    if (!edit.empty()) rest.patch(path, edit);
    auto dive = rest.get(path);
    const auto findings = rest.list(path + "/findings", {});
    const auto truth = rest.list(path + "/truth", {});
    if (context.json) {
        dive["findings"] = findings;
        dive["truth"] = truth;
    }
    std::cout << dive.dump(2) << '\n';
    if (context.json) return kExitDone;
    for (const auto& item : findings) std::cout << finding_text(item.get<Finding>());
    for (const auto& item : truth) std::cout << truth_text(item.get<TruthFile>());
    return kExitDone;
}

}  // namespace

void add_dives(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("dives", "list the dives on a server, or show one");
    auto options = std::make_shared<DivesOptions>();
    command->add_option(
        "dive", options->dive_id, "id of a dive: show it with its findings and truth files");
    add_server_options(*command, options->server);
    command->add_option("--site", options->site, "list only dives of this site");
    command->add_option(
        "--state", options->state, "list only dives in this state: checking, ready or refused");
    add_newest(*command, options->newest);
    command
        ->add_option("--edit",
                     options->edits,
                     "edit the dive: name=, site=, rig=, tags=a,b, notes= or "
                     "position=latitude,longitude (may be repeated); the recording stays as it is")
        ->allow_extra_args(false);
    command
        ->add_option("--recorded",
                     options->recorded,
                     "take the recording's own value of this field again (may be repeated)")
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"name", "site", "rig", "tags", "notes", "position"}));
    command->callback([options, &context] {
        context.command = [options, &context] {
            client::RestClient rest(account_of(options->server));
            return options->dive_id.empty() ? list_dives(rest, *options, context)
                                            : show_dive(rest, *options, context);
        };
    });
}

}  // namespace divemesh::cli
