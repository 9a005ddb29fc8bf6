#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <nlohmann/json.hpp>

namespace divemesh::cli {

// What every sub-command gets from the program.
struct Context {
    bool json = false;             // --json: results for machines
    std::function<int()> command;  // runs the chosen sub-command; returns the exit code
};

// One function per sub-command, in the file of its name: declares its options and sets
// `context.command`.
void add_serve(CLI::App& app, Context& context);
void add_worker(CLI::App& app, Context& context);
void add_attempt(CLI::App& app, Context& context);
void add_token(CLI::App& app, Context& context);
void add_backup(CLI::App& app, Context& context);
void add_restore(CLI::App& app, Context& context);
void add_sensor(CLI::App& app, Context& context);
void add_upload(CLI::App& app, Context& context);
void add_dives(CLI::App& app, Context& context);
void add_jobs(CLI::App& app, Context& context);
void add_download(CLI::App& app, Context& context);
void add_cancel(CLI::App& app, Context& context);
void add_retry(CLI::App& app, Context& context);
void add_share(CLI::App& app, Context& context);
void add_queue(CLI::App& app, Context& context);
void add_workers(CLI::App& app, Context& context);
void add_schedules(CLI::App& app, Context& context);
void add_reconstruct(CLI::App& app, Context& context);
void add_export(CLI::App& app, Context& context);
void add_compare(CLI::App& app, Context& context);
void add_calibrate(CLI::App& app, Context& context);
void add_evaluate(CLI::App& app, Context& context);
void add_import(CLI::App& app, Context& context);
void add_report(CLI::App& app, Context& context);
void add_measure(CLI::App& app, Context& context);
void add_simulate(CLI::App& app, Context& context);
void add_demo(CLI::App& app, Context& context);
void add_validate(CLI::App& app, Context& context);

}  // namespace divemesh::cli
