#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/data_options.hpp"
#include "cli/exit_code.hpp"
#include "cli/stop_signal.hpp"
#include "worker/job_runner.hpp"

namespace divemesh::cli {

void add_worker(CLI::App& app, Context& context) {
    struct Options {
        DataOptions data;
        worker::WorkerConfig config;
    };
    auto* command = app.add_subcommand("worker", "take jobs from a catalog and run them");
    auto options = std::make_shared<Options>();
    add_data_options(*command, options->data);
    command->add_option("--slots", options->config.num_slots, "jobs at a time")
        ->capture_default_str()
        ->check(CLI::Range(1, 256));
    command->add_option("--threads", options->config.num_threads, "per job; 0: all cores")
        ->capture_default_str()
        ->check(CLI::Range(0, 1024));
    command->add_option("--work", options->config.work_folder, "scratch; else beside the blobs");
    command->callback([options, &context] {
        context.command = [options] {
            options->config.catalog_url = catalog_url(options->data);
            options->config.blobs_url = blobs_url(options->data);
            if (options->config.work_folder.empty())
                options->config.work_folder = work_folder(options->data);
            StopSignal signal;
            worker::run_worker(options->config, signal.token());
            return kExitDone;
        };
    });
}

}  // namespace divemesh::cli
