#include <filesystem>
#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/send_dive.hpp"
#include "cli/server_options.hpp"
#include "schemas/error.hpp"
#include "schemas/reconstruction_options.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;
namespace client = api::client;

struct UploadOptions {
    SendOptions send;
    ServerOptions server;
    bool wait = false;
    fs::path download;
};

void print(const SentDive& sent, bool as_json) {
    nlohmann::json result = {{"dive", sent.dive.id}, {"verified", sent.verified}};
    if (!sent.job_id.empty()) result["job"] = sent.job_id;
    if (as_json) {
        std::cout << result.dump(2) << std::endl;
        return;
    }
    std::cout << "dive " << sent.dive.id << std::endl;
    if (!sent.job_id.empty()) std::cout << "job " << sent.job_id << std::endl;
}

int upload(const UploadOptions& options, const Context& context) {
    client::RestClient rest(account_of(options.server));
    const PresetOptions& preset = options.send.preset;
    make_options(preset.preset, overrides_of(preset.set));
    if (options.send.no_job && !preset.set.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "--set has no effect with --no-job: leave one of them out");
    const SentDive sent = send_dive(rest, options.send);
    print(sent, context.json);
    if (!options.wait && options.download.empty()) return kExitDone;
    const bool done = options.send.no_job
                          ? wait_for_dive(rest, sent.dive.id).state == DiveState::Ready
                          : fetch_results(rest, sent.job_id, options.download);
    return done ? kExitDone : kExitFailed;
}

}  // namespace

void add_upload(CLI::App& app, Context& context) {
    auto* command =
        app.add_subcommand("upload", "upload a dive to a server and have it reconstructed");
    auto options = std::make_shared<UploadOptions>();
    command
        ->add_option("dive",
                     options->send.dive,
                     "folder, archive (zip, tar, tar.gz, tar.zst), ROS bag or MCAP")
        ->required()
        ->check(CLI::ExistingPath);
    add_server_options(*command, options->server);
    add_preset_options(*command, options->send.preset);
    command->add_flag("--no-job", options->send.no_job, "store the dive, do not reconstruct it");
    command->add_flag("--wait", options->wait, "wait until the job has finished");
    command->add_option(
        "--download", options->download, "then download the artifacts to this folder");
    command
        ->add_option("--limit-rate",
                     options->send.limit_rate_bytes_per_s,
                     "max bytes per second to send (500k, 2M; 0: no limit)")
        ->transform(CLI::AsSizeValue(true));
    options->server.give_up_after_s = 0.0;
    add_give_up_after(*command, options->server);
    command
        ->add_option("--stall-timeout",
                     options->send.stall_timeout_s,
                     "reconnect after this many seconds without a byte")
        ->check(CLI::Range(0.1, 3600.0))
        ->capture_default_str();
    command
        ->add_option("--parallel",
                     options->send.parallel,
                     "parts to send at once, for fast links with a long delay")
        ->check(CLI::Range(1, 16))
        ->capture_default_str();
    command->footer(
        "After any interruption, even a restart of the machine, the same command resumes the "
        "upload.\n"
        "The recording is only read; you may delete it after exit code 0 and the word\n"
        "\"verified\". Exit codes: 0 done, 1 refused or failed, 2 wrong usage.");
    command->callback([options, &context] {
        context.command = [options, &context] { return upload(*options, context); };
    });
}

}  // namespace divemesh::cli
