#include "worker/compare/compare.hpp"

#include <cstdio>
#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/follow.hpp"
#include "cli/interrupt.hpp"
#include "cli/jobs_by_server.hpp"
#include "cli/server_options.hpp"
#include "cli/text.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"

namespace divemesh::cli {
namespace {

std::string scaled(const nlohmann::json& interval, double factor, const char* unit) {
    char text[120];
    std::snprintf(text,
                  sizeof text,
                  "%.2f (%.2f to %.2f) %s",
                  factor * interval.at("value").get<double>(),
                  factor * interval.at("low").get<double>(),
                  factor * interval.at("high").get<double>(),
                  unit);
    return text;
}

std::string summary(const nlohmann::json& document) {
    const nlohmann::json& fit = document.at("registration");
    const nlohmann::json& ground = document.at("ground");
    char text[400];
    std::snprintf(text,
                  sizeof text,
                  "aligned by %s: %.0f %% of the ground agrees, residual %.1f mm\n"
                  "seen by both: %.2f m2; by only one: %.2f m2; level of detection: %.1f mm\n",
                  fit.at("method").get<std::string>().c_str(),
                  100.0 * fit.at("agreement").get<double>(),
                  1e3 * fit.at("residual_rms_m").get<double>(),
                  ground.at("both_m2").get<double>(),
                  ground.at("only_a_m2").get<double>() + ground.at("only_b_m2").get<double>(),
                  1e3 * document.at("distances").at("median_lod95_m").get<double>());
    std::vector<std::vector<std::string>> rows = {{"", "PATCHES", "VOLUME (95 %)", "AREA (95 %)"}};
    for (const char* kind : {"grown", "lost"}) {
        const nlohmann::json& total = document.at(kind);
        rows.push_back({kind,
                        std::to_string(total.at("num_patches").get<int>()),
                        scaled(total.at("volume_m3"), 1e3, "l"),
                        scaled(total.at("area_m2"), 1.0, "m2")});
    }
    std::string findings;
    for (const nlohmann::json& finding : document.value("findings", nlohmann::json::array()))
        findings += finding_text(finding.get<Finding>());
    return text + table_text(rows) + findings;
}

int run(const compare::CompareRequest& request, const Context& context) {
    catch_interrupts();
    nlohmann::json document;
    {
        ProgressBar bar;
        document = compare::compare_reconstructions(request, [&](const Progress& progress) {
            throw_if_interrupted();
            show_progress(bar, progress);
        });
    }
    std::cout << (context.json ? document.dump(2) + "\n" : summary(document));
    return kExitDone;
}

struct ServerSide {
    ServerOptions server;
    bool wait = true;
};

// Compares two dives or reconstructions on a server.
int run_there(const compare::CompareRequest& request,
              const ServerSide& there,
              const Context& context) {
    const compare::CompareOptions& options = request.options;
    if (request.later_areas && !request.areas)
        throw Error(
            ErrorCode::InvalidArgument,
            "--later-areas was given without --areas: give the areas of the earlier dive too");
    ServerJob wanted{.subject = request.a.string(),
                     .kind = "compare",
                     .options = {{"with", request.b.string()},
                                 {"cell_m", options.cell_m},
                                 {"normal_scale_m", options.normal_scale_m},
                                 {"cylinder_m", options.cylinder_m},
                                 {"reach_m", options.reach_m},
                                 {"least_area_m2", options.least_area_m2}},
                     .wait = there.wait,
                     .out = request.out};
    if (request.areas) wanted.truth["areas"] = {*request.areas, "areas", wanted.subject};
    if (request.later_areas)
        wanted.truth["later_areas"] = {*request.later_areas, "areas", request.b.string()};
    api::client::RestClient rest(account_of(there.server));
    return run_on_server(rest, wanted, context, [&](const std::string& artifacts) {
        const auto document = rest.get(artifacts + "compare.json");
        std::cout << (context.json ? document.dump(2) + "\n" : summary(document));
        return kExitDone;
    });
}

}  // namespace

void add_compare(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("compare", "compare two dives of one place");
    auto request = std::make_shared<compare::CompareRequest>();
    auto& options = request->options;
    auto there = std::make_shared<ServerSide>();
    add_server_options(*command, there->server);
    add_give_up_after(*command, there->server);
    // clang-format off
    command->add_option("a", request->a, "folder of the earlier reconstruction; with --server, id of its dive or job")->required();
    command->add_option("b", request->b, "folder of the later reconstruction, or its id")->required();
    command->add_option("--out", request->out, "output folder, created if missing")->required();
    command->add_option("--areas", request->areas, "JSON with polygons and quadrats on the earlier model, as for `measure`");
    command->add_option("--later-areas", request->later_areas, "the same on the later model, for the change per label");
    command->add_option("--cell-m", options.cell_m, "cell size of the maps, m; 0: from the meshes")->capture_default_str();
    command->add_option("--cylinder-m", options.cylinder_m, "M3C2: diameter of the cylinder; 0: 4 cells")->capture_default_str();
    command->add_option("--normal-scale-m", options.normal_scale_m, "M3C2: scale of the normals; 0: 8 cells")->capture_default_str();
    command->add_option("--reach-m", options.reach_m, "M3C2: max distance along the normal")->capture_default_str();
    command->add_option("--least-area-m2", options.least_area_m2, "min area of a patch; 0: from the cylinder")->capture_default_str();
    command->add_option("--threads", request->num_threads, "0: all cores; the result does not depend on it")->capture_default_str();
    command->add_flag("--wait,!--no-wait", there->wait, "with --server: wait until it is done (default)");
    // clang-format on
    command->callback([request, there, command, &context] {
        const bool is_there = is_on_server(*command, request->a);
        context.command = [request, there, is_there, &context] {
            return is_there ? run_there(*request, *there, context) : run(*request, context);
        };
    });
}

}  // namespace divemesh::cli
