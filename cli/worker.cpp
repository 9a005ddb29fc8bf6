#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/data_options.hpp"
#include "cli/exit_code.hpp"
#include "cli/stop_signal.hpp"
#include "server/log.hpp"
#include "worker/runner/job_runner.hpp"

namespace divemesh::cli {
namespace {

constexpr std::int64_t kCache_bytes = std::int64_t{20} << 30;

}  // namespace

void add_worker(CLI::App& app, Context& context) {
    struct Options {
        DataOptions data{.existing_only = true};
        runner::WorkerConfig config{.cache_bytes = kCache_bytes};
    };
    auto* command = app.add_subcommand("worker", "run jobs from a catalog");
    auto options = std::make_shared<Options>();
    auto& config = options->config;
    // clang-format off
    add_data_options(*command, options->data);
    command->add_option("--slots", config.num_slots, "jobs to run at a time")->capture_default_str()->check(CLI::Range(1, 256));
    command->add_option("--threads", config.num_threads, "threads per job; 0: all cores")->capture_default_str()->check(CLI::Range(0, 1024));
    command->add_option("--work", config.work_folder, "scratch folder; default: beside the blobs");
    command->add_option("--memory", config.limits.max_memory_bytes, "max memory of an attempt (16G); default: 0.9 of the machine's, shared by the slots")->transform(CLI::AsSizeValue(true));
    command->add_option("--scratch", config.scratch_bytes, "max disk space of an attempt (100G); default: 0.9 of the free space, shared by the slots")->transform(CLI::AsSizeValue(true));
    command->add_option("--min-free", config.min_free_bytes, "free space to keep on the scratch disk (10G); no job starts with less")->transform(CLI::AsSizeValue(true));
    command->add_option("--cache", config.cache_bytes, "max size of the cache of stage results (20G); 0: no cache")->transform(CLI::AsSizeValue(true));
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
            runner::run_worker(options->config, signal.token());
            return kExitDone;
        };
    });
}

}  // namespace divemesh::cli
