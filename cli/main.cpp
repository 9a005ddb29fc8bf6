#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <new>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"

namespace divemesh::cli {
namespace {

std::string default_config_file() {
    if (const char* folder = std::getenv("XDG_CONFIG_HOME"); folder != nullptr && *folder != '\0')
        return std::string(folder) + "/divemesh.toml";
    const char* home = std::getenv("HOME");
    return std::string(home != nullptr ? home : "") + "/.config/divemesh.toml";
}

// Lets every long option of every sub-command be given as DIVEMESH_NAME too.
void name_variables(CLI::App& app) {
    for (CLI::Option* option : app.get_options()) {
        const auto& names = option->get_lnames();
        if (names.empty() || names[0] == "help" || names[0] == "version") continue;
        std::string variable = "DIVEMESH_" + names[0];
        std::transform(variable.begin(), variable.end(), variable.begin(), [](unsigned char c) {
            return static_cast<char>(c == '-' ? '_' : std::toupper(c));
        });
        option->envname(variable);
    }
    for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        name_variables(*command);
}

int report(const Context& context, const Error& error) {
    std::cerr << "divemesh: " << error.what() << '\n';
    if (context.json)
        std::cout << nlohmann::json{{"error",
                                     {{"code", to_string(error.code())},
                                      {"message", error.what()}}}}
                         .dump(2)
                  << '\n';
    return exit_code_of(error.code());
}

int run(int argc, char** argv) {
    CLI::App app("Underwater 3D reconstruction: turns a recorded dive into a measured mesh.",
                 "divemesh");
    app.set_version_flag("--version", DIVEMESH_VERSION);
    app.require_subcommand(1);
    app.fallthrough();
    Context context;
    app.add_flag("--json", context.json, "print results as JSON");
    // clang-format off
    for (const auto add : {add_reconstruct, add_validate, add_evaluate, add_compare, add_export, add_report,
                           add_measure, add_simulate, add_demo, add_import, add_calibrate,
                           add_serve, add_worker, add_attempt, add_token, add_backup, add_restore,
                           add_sensor, add_upload, add_dives, add_jobs, add_download, add_cancel,
                           add_retry, add_share, add_queue, add_workers, add_schedules})
        add(app, context);
    // clang-format on
    name_variables(app);
    app.set_config("--config", default_config_file(), "TOML file with a [section] per sub-command");
    app.footer(
        "Every option can also be set as DIVEMESH_<NAME> or in the config file. "
        "Exit codes: 0 done, 1 the work failed, 2 wrong usage, 3 a requirement is not met.");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? kExitDone : kExitUsage;
    }
    try {
        return context.command();
    } catch (const Error& error) {
        return report(context, error);
    } catch (const std::bad_alloc&) {
        return report(context,
                      Error(ErrorCode::OutOfMemory,
                            "out of memory: close other programs, or allow this process more"));
    } catch (const std::exception& error) {
        return report(
            context, Error(ErrorCode::Unavailable, std::string("internal error: ") + error.what()));
    }
}

}  // namespace
}  // namespace divemesh::cli

int main(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);
    try {
        return divemesh::cli::run(argc, argv);
    } catch (const std::exception& error) {  // while setting up, or while reporting an error
        std::cerr << "divemesh: internal error: " << error.what() << '\n';
        return divemesh::cli::kExitFailed;
    }
}
