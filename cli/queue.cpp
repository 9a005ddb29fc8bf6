#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "api/client/backoff.hpp"
#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/progress_bar.hpp"
#include "cli/server_options.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"

namespace divemesh::cli {
namespace {

namespace client = api::client;

struct QueueOptions {
    ServerOptions server;
    std::string project;
    bool pause = false;
    bool resume = false;
    bool wait = false;
    std::optional<int> max_running;
    std::optional<int> keep_results;
    std::optional<int> redrive;
};

client::QueryParameters query_of(const QueueOptions& options) {
    if (options.project.empty()) return {};
    return {{"project", options.project}};
}

void show(const Queue& queue, const Context& context) {
    if (context.json) {
        std::cout << nlohmann::json(queue).dump(2) << '\n';
        return;
    }
    std::cout << (queue.project.empty() ? "all projects" : "project " + queue.project)
              << (queue.paused ? ", paused" : "");
    if (queue.max_running > 0) std::cout << ", " << queue.max_running << " at a time";
    if (queue.keep_results > 0)
        std::cout << ", keeps " << queue.keep_results << " results of a dive";
    std::cout << '\n';
    for (const auto& [state, count] : queue.num_jobs)
        std::cout << "  " << state << ' ' << count << '\n';
}

void change(client::RestClient& rest, const QueueOptions& options) {
    nlohmann::json body = {{"project", options.project}};
    if (options.pause || options.resume) body["paused"] = options.pause;
    if (options.max_running) body["max_running"] = *options.max_running;
    if (options.keep_results) body["keep_results"] = *options.keep_results;
    if (body.size() > 1) rest.patch("/api/v1/queue", body);
}

void redrive(client::RestClient& rest, const QueueOptions& options) {
    if (!options.redrive) return;
    nlohmann::json body = {{"limit", *options.redrive}};
    if (!options.project.empty()) body["project"] = options.project;
    for (const auto& job : rest.post("/api/v1/queue/redrive", body).at("items"))
        std::cerr << job.at("id").get<std::string>() << " queued again\n";
}

Queue wait_until_drained(client::RestClient& rest, const QueueOptions& options) {
    const auto ask = [&] { return rest.get("/api/v1/queue", query_of(options)).get<Queue>(); };
    if (!options.wait) return ask();
    ProgressBar bar;
    client::Backoff backoff(rest.account().give_up_after, say_waiting(bar));
    for (;;) {
        Queue queue = backoff.until_done(ask);
        backoff.moved();
        if (queue.num_jobs.at("running") == 0) return queue;
        std::this_thread::sleep_for(std::chrono::seconds(1));
    }
}

std::string state_text(const Worker& worker) {
    if (!worker.alive) return "lost";
    if (worker.draining) return "draining";
    return worker.waits_for.empty() ? "alive" : "waits for " + worker.waits_for;
}

int list_workers(client::RestClient& rest, const Context& context) {
    const auto items = rest.list("/api/v1/workers", {});
    if (context.json) {
        std::cout << nlohmann::json(items).dump(2) << '\n';
        return kExitDone;
    }
    std::vector<std::vector<std::string>> rows = {{"NAME", "RUNNING", "SLOTS", "STATE", "SEEN"}};
    for (const auto& item : items) {
        const Worker worker = item.get<Worker>();
        rows.push_back({worker.name,
                        std::to_string(worker.num_running),
                        std::to_string(worker.num_slots),
                        state_text(worker),
                        time_text(worker.seen_at_ms)});
    }
    std::cout << table_text(rows);
    return kExitDone;
}

}  // namespace

void add_queue(CLI::App& app, Context& context) {
    auto* command =
        app.add_subcommand("queue", "show, pause or limit the queue; put dead jobs back");
    auto options = std::make_shared<QueueOptions>();
    add_server_options(*command, options->server);
    // clang-format off
    command->add_option("--project", options->project, "only this project");
    auto* pause = command->add_flag("--pause", options->pause, "start no more jobs; running jobs continue");
    command->add_flag("--resume", options->resume, "start jobs again")->excludes(pause);
    command->add_flag("--wait", options->wait, "wait until no job is running (drained)");
    add_give_up_after(*command, options->server);
    command->add_option("--max-running", options->max_running, "max jobs at a time; 0: no limit")->check(CLI::Range(0, 1'000'000));
    command->add_option("--keep-results", options->keep_results, "results of each dive and kind to keep, the newest; 0: all")->check(CLI::Range(0, 1'000'000));
    command->add_option("--redrive", options->redrive, "put up to this many dead jobs back into the queue")->check(CLI::Range(1, 1000));
    // clang-format on
    command->callback([options, &context] {
        context.command = [options, &context] {
            client::RestClient rest(account_of(options->server));
            change(rest, *options);
            redrive(rest, *options);
            show(wait_until_drained(rest, *options), context);
            return kExitDone;
        };
    });
}

void add_workers(CLI::App& app, Context& context) {
    struct Options {
        ServerOptions server;
        std::string name;
        bool drain = false;
        bool resume = false;
    };
    auto* command = app.add_subcommand("workers", "list the workers on a server, or drain one");
    auto options = std::make_shared<Options>();
    auto* name = command->add_option("worker", options->name, "name of a worker");
    add_server_options(*command, options->server);
    auto* drain =
        command->add_flag("--drain", options->drain, "finish the current jobs, take no more");
    drain->needs(name);
    command->add_flag("--resume", options->resume, "take jobs again")->excludes(drain)->needs(name);
    command->callback([options, &context] {
        context.command = [options, &context] {
            client::RestClient rest(account_of(options->server));
            if (options->drain || options->resume)
                rest.patch("/api/v1/workers/" + client::percent_encode(options->name),
                           {{"draining", options->drain}});
            return list_workers(rest, context);
        };
    });
}

}  // namespace divemesh::cli
