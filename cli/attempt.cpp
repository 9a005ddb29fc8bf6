#include "worker/attempt/attempt.hpp"

#include <memory>

#include "cli/command.hpp"

namespace divemesh::cli {

void add_attempt(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("attempt", "run one attempt at a job (started by a worker)");
    command->group("");  // hidden from the help
    auto request = std::make_shared<std::filesystem::path>();
    command->add_option("request", *request, "the request, as JSON")->required();
    command->callback([request, &context] {
        context.command = [request] { return attempt::run_attempt(*request); };
    });
}

}  // namespace divemesh::cli
