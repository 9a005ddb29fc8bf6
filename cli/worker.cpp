#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/data_options.hpp"
#include "cli/exit_code.hpp"
#include "cli/stop_signal.hpp"
#include "server/log.hpp"
#include "worker/job_runner.hpp"

namespace divemesh::cli {
namespace {

constexpr std::int64_t kCache_bytes = std::int64_t{20} << 30;

}  // namespace

void add_worker(CLI::App& app, Context& context) {
    struct Options {
        DataOptions data;
        worker::WorkerConfig config{.cache_bytes = kCache_bytes};
    };
    auto* command = app.add_subcommand("worker", "take jobs from a catalog and run them");
    auto options = std::make_shared<Options>();
    auto& config = options->config;
    // clang-format off
    add_data_options(*command, options->data);
    command->add_option("--slots", config.num_slots, "jobs at a time")->capture_default_str()->check(CLI::Range(1, 256));
    command->add_option("--threads", config.num_threads, "per job; 0: all cores")->capture_default_str()->check(CLI::Range(0, 1024));
    command->add_option("--work", config.work_folder, "scratch; else beside the blobs");
    command->add_option("--memory", config.limits.max_memory_bytes, "that an attempt may take (16G); else 0.9 of the machine's, shared by the slots")->transform(CLI::AsSizeValue(true));
    command->add_option("--scratch", config.scratch_bytes, "room on the disk that an attempt may take (100G); else 0.9 of what is free, shared by the slots")->transform(CLI::AsSizeValue(true));
    command->add_option("--min-free", config.min_free_bytes, "room on the disk of the scratch that is never used: no job is begun with less (10G)")->transform(CLI::AsSizeValue(true));
    command->add_option("--cache", config.cache_bytes, "room for what stages made, kept for other attempts (20G); 0: nothing is kept")->transform(CLI::AsSizeValue(true));
    // clang-format on
    command->callback([options, &context] {
        context.command = [options] {
            options->config.catalog_url = catalog_url(options->data);
            options->config.blobs_url = blobs_url(options->data);
            if (options->config.work_folder.empty())
                options->config.work_folder = work_folder(options->data);
            options->config.cache_folder = cache_folder(options->data);
            server::start_log();
            StopSignal signal;
            worker::run_worker(options->config, signal.token());
            return kExitDone;
        };
    });
}

}  // namespace divemesh::cli
