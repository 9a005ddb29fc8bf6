#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/server_options.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"
#include "schemas/shown_job.hpp"

namespace divemesh::cli {
namespace {

namespace client = api::client;

struct JobsOptions {
    ServerOptions server;
    std::string dive_id;
    std::string state;
    std::string job_id;
    int newest = 0;  // 0: all, the oldest first
    bool log = false;
    int attempt = 0;  // 0: the newest
    bool wait = false;
    bool pause = false;
    bool resume = false;
    bool deleted = false;  // list those whose result was deleted
    bool remove = false;
    bool restore = false;
    std::optional<int> priority;
};

std::string percent_text(double fraction) {
    return std::to_string(static_cast<int>(fraction * 100.0)) + " %";
}

int list_jobs(client::RestClient& rest, const JobsOptions& options, const Context& context) {
    client::QueryParameters query;
    if (!options.dive_id.empty()) query.emplace_back("dive_id", options.dive_id);
    if (!options.state.empty())
        query.emplace_back("state", to_string(job_state_from_string(options.state)));
    if (options.deleted) query.emplace_back("deleted", "true");
    const auto items = listed(rest, "/api/v1/jobs", query, options.newest);
    if (context.json) {
        std::cout << nlohmann::json(items).dump(2) << '\n';
        return kExitDone;
    }
    std::vector<std::vector<std::string>> rows = {// clang-format off
        {"ID", "DIVE", "KIND", "PRESET", "STATE", "DONE", "VERDICT", "TRIES", "PLACE", "WAITS FOR", "CREATED", "FAILURE"}};
    // clang-format on
    for (const auto& item : items) {
        const ShownJob job = item.get<ShownJob>();
        rows.push_back({job.id,
                        job.dive_id,
                        std::string(to_string(job.kind)),
                        job.preset,
                        std::string(to_string(job.state)),
                        percent_text(job.progress.fraction),
                        std::string(verdict_of(job)),
                        std::to_string(job.num_attempts),
                        job.forecast ? std::to_string(job.forecast->position) : "",
                        job.waits_for,
                        time_text(job.created_at_ms),
                        job.failure.message});
    }
    std::cout << table_text(rows);
    return kExitDone;
}

void change_job(client::RestClient& rest, const JobsOptions& options) {
    nlohmann::json body = nlohmann::json::object();
    if (options.pause || options.resume) body["paused"] = options.pause;
    if (options.priority) body["priority"] = *options.priority;
    if (!body.empty()) rest.patch(client::job_path(options.job_id), body);
    if (options.remove) rest.remove(client::job_path(options.job_id));
    if (options.restore)
        rest.post(client::job_path(options.job_id) + "/restore", nlohmann::json::object());
}

int show_job(client::RestClient& rest, const JobsOptions& options) {
    change_job(rest, options);
    if (options.log) {
        const std::string attempt =
            options.attempt > 0 ? "/attempts/" + std::to_string(options.attempt) : "";
        std::cout << rest.get_text(client::job_path(options.job_id) + attempt + "/log");
        return kExitDone;
    }
    if (!options.wait) {
        std::cout << rest.get(client::job_path(options.job_id)).dump(2) << '\n';
        return kExitDone;
    }
    const Job job = wait_for_job(rest, options.job_id);
    std::cout << nlohmann::json(job).dump(2) << '\n';
    if (job.state == JobState::Succeeded) return kExitDone;
    print_failure(rest, job);
    return kExitFailed;
}

void add_job_action(CLI::App& app,
                    Context& context,
                    const std::string& name,
                    const std::string& description) {
    auto* command = app.add_subcommand(name, description);
    auto options = std::make_shared<JobsOptions>();
    command->add_option("job", options->job_id, "id of the job")->required();
    add_server_options(*command, options->server);
    command->callback([options, &context, name] {
        context.command = [options, &context, name] {
            client::RestClient rest(account_of(options->server));
            const auto job =
                rest.post(client::job_path(options->job_id) + "/" + name, nlohmann::json::object())
                    .get<Job>();
            if (context.json)
                std::cout << nlohmann::json(job).dump(2) << '\n';
            else if (job.state == JobState::Running && job.cancel_requested)
                std::cout << job.id << " is being cancelled\n";
            else
                std::cout << job.id << ' ' << to_string(job.state) << '\n';
            return kExitDone;
        };
    });
}

}  // namespace

void add_jobs(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("jobs", "list the jobs on a server, or show one");
    auto options = std::make_shared<JobsOptions>();
    // clang-format off
    command->add_option("job", options->job_id, "id of a job: show all of it");
    add_server_options(*command, options->server);
    command->add_option("--dive", options->dive_id, "list only jobs of this dive");
    command->add_option("--state",
                        options->state,
                        "list only jobs in this state: held, queued, running, succeeded, failed, dead or cancelled");
    add_newest(*command, options->newest);
    auto* log = command->add_flag("--log", options->log, "print the log of the latest attempt");
    command->add_option("--attempt", options->attempt, "with --log: number of the attempt")->needs(log)->check(CLI::Range(1, 1'000'000));
    command->add_flag("--wait", options->wait, "wait until the job has finished");
    add_give_up_after(*command, options->server);
    auto* pause = command->add_flag("--pause", options->pause, "hold a queued job");
    command->add_flag("--resume", options->resume, "release a held job")->excludes(pause);
    command->add_flag("--deleted", options->deleted, "list only jobs whose result was deleted");
    auto* remove = command->add_flag("--delete", options->remove, "delete the result of a finished job; it can be restored for a while");
    command->add_flag("--restore", options->restore, "restore a deleted result")->excludes(remove);
    command->add_option("--priority", options->priority, "priority of a queued job; one step counts as ten minutes of waiting")->check(CLI::Range(-100, 100));
    // clang-format on
    command->callback([options, &context] {
        context.command = [options, &context] {
            client::RestClient rest(account_of(options->server));
            return options->job_id.empty() ? list_jobs(rest, *options, context)
                                           : show_job(rest, *options);
        };
    });
}

void add_cancel(CLI::App& app, Context& context) {
    add_job_action(app, context, "cancel", "stop a job");
}

void add_retry(CLI::App& app, Context& context) {
    add_job_action(app, context, "retry", "run a failed, dead or cancelled job again");
}

}  // namespace divemesh::cli
