#include <filesystem>
#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/server_options.hpp"

namespace divemesh::cli {
namespace {

struct DownloadOptions {
    ServerOptions server;
    std::string job_id;
    std::vector<std::string> names;
    std::filesystem::path out = ".";
};

}  // namespace

void add_download(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("download", "download the artifacts of a job");
    auto options = std::make_shared<DownloadOptions>();
    command->add_option("job", options->job_id, "id of the job")->required();
    command->add_option(
        "names", options->names, "names of artifacts, e.g. mesh.glb metrics.json; default: all");
    command->add_option("--out", options->out, "output folder, created if missing")
        ->capture_default_str();
    add_server_options(*command, options->server);
    add_give_up_after(*command, options->server);
    command->footer("Files that are complete are skipped; interrupted downloads resume.");
    command->callback([options, &context] {
        context.command = [options] {
            api::client::RestClient rest(account_of(options->server));
            download_job(rest, options->job_id, options->names, options->out);
            return kExitDone;
        };
    });
}

}  // namespace divemesh::cli
