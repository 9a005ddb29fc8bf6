#include "worker/attempt.hpp"

#include <memory>

#include "cli/command.hpp"

namespace divemesh::cli {

void add_attempt(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("attempt", "one attempt at a job: the child of a worker");
    command->group("");  // not for people
    auto request = std::make_shared<std::filesystem::path>();
    command->add_option("request", *request, "what to do")->required();
    command->callback([request, &context] {
        context.command = [request] { return worker::run_attempt(*request); };
    });
}

}  // namespace divemesh::cli
