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
    auto* command = app.add_subcommand("download", "fetch the artifacts of a job");
    auto options = std::make_shared<DownloadOptions>();
    command->add_option("job", options->job_id, "id of the job")->required();
    command->add_option("names", options->names, "mesh.glb metrics.json ...; none: all of them");
    command->add_option("--out", options->out, "folder, made when missing")->capture_default_str();
    add_server_options(*command, options->server);
    command->footer("What is there already is left; what was cut goes on where it stopped.");
    command->callback([options, &context] {
        context.command = [options] {
            api::client::RestClient rest(account_of(options->server));
            download_job(rest, options->job_id, options->names, options->out);
            return kExitDone;
        };
    });
}

}  // namespace divemesh::cli
