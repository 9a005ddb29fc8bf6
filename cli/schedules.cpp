#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/server_options.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"
#include "schemas/requirement.hpp"

namespace divemesh::cli {
namespace {

namespace client = api::client;

constexpr const char* kPath = "/api/v1/schedules";

struct SchedulesOptions {
    ServerOptions server;
    std::string id;
    std::string cron;
    std::string tag;
    std::string preset = "standard";
    std::string lever_arm;
    std::string time_offset;
    std::vector<std::string> requirements;
    bool fresh = true;
};

int list_schedules(client::RestClient& rest, const Context& context) {
    const auto items = rest.list(kPath, {});
    if (context.json) {
        std::cout << nlohmann::json(items).dump(2) << '\n';
        return kExitDone;
    }
    std::vector<std::vector<std::string>> rows = {
        {"ID", "CRON (UTC)", "TAG", "PRESET", "NEXT", "LAST", "JOBS", "PROBLEM"}};
    for (const auto& item : items) {
        const Schedule schedule = item.get<Schedule>();
        rows.push_back({schedule.id,
                        schedule.cron,
                        schedule.tag,
                        schedule.preset,
                        time_text(schedule.next_run_ms),
                        time_text(schedule.last_run_ms),
                        std::to_string(schedule.last_num_jobs),
                        schedule.last_problem});
    }
    std::cout << table_text(rows);
    return kExitDone;
}

int add_schedule(client::RestClient& rest,
                 const SchedulesOptions& options,
                 const Context& context) {
    nlohmann::json of_reports = {{"fresh", options.fresh}};
    for (const std::string& text : options.requirements) parse_requirement(text);
    if (!options.requirements.empty()) of_reports["require"] = options.requirements;
    if (!options.lever_arm.empty()) of_reports["lever_arm"] = options.lever_arm;
    if (!options.time_offset.empty()) of_reports["time_offset"] = options.time_offset;
    const auto made = rest.post(kPath,
                                {{"cron", options.cron},
                                 {"tag", options.tag},
                                 {"preset", options.preset},
                                 {"options", of_reports}});
    const Schedule schedule = made.get<Schedule>();
    if (context.json)
        std::cout << made.dump(2) << '\n';
    else
        std::cout << schedule.id << ", next at " << time_text(schedule.next_run_ms) << '\n';
    return kExitDone;
}

int remove_schedule(client::RestClient& rest, const SchedulesOptions& options) {
    rest.remove(std::string(kPath) + "/" + client::percent_encode(options.id));
    return kExitDone;
}

}  // namespace

void add_schedules(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("schedules", "manage scheduled accuracy reports");
    command->require_subcommand(1);
    auto options = std::make_shared<SchedulesOptions>();

    auto* list = command->add_subcommand("list", "list all schedules with their last run");
    add_server_options(*list, options->server);
    list->callback([options, &context] {
        context.command = [options, &context] {
            client::RestClient rest(account_of(options->server));
            return list_schedules(rest, context);
        };
    });

    auto* add = command->add_subcommand("add", "report regularly on every dive with a tag");
    add_server_options(*add, options->server);
    // clang-format off
    add->add_option("--cron", options->cron, "'30 4 * * mon': minute, hour, day, month, weekday in UTC")->required();
    add->add_option("--tag", options->tag, "tag of the dives")->required();
    add->add_option("--preset", options->preset, "preset of the reconstructions made for it")->capture_default_str();
    add->add_option("--require", options->requirements, "as for `report`; may be repeated")->allow_extra_args(false);
    add->add_option("--lever-arm", options->lever_arm, "as for `report`");
    add->add_option("--time-offset", options->time_offset, "as for `report`");
    add->add_flag("--fresh,!--no-fresh", options->fresh, "reconstruct with the program version of that day (default)");
    // clang-format on
    add->callback([options, &context] {
        context.command = [options, &context] {
            client::RestClient rest(account_of(options->server));
            return add_schedule(rest, *options, context);
        };
    });

    auto* remove = command->add_subcommand("remove", "remove a schedule; its reports are kept");
    add_server_options(*remove, options->server);
    remove->add_option("schedule", options->id, "id of the schedule")->required();
    remove->callback([options, &context] {
        context.command = [options] {
            client::RestClient rest(account_of(options->server));
            return remove_schedule(rest, *options);
        };
    });
}

}  // namespace divemesh::cli
