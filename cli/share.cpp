#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/server_options.hpp"
#include "cli/text.hpp"
#include "schemas/wall_clock.hpp"

namespace divemesh::cli {
namespace {

namespace client = api::client;

struct ShareOptions {
    ServerOptions server;
    std::string job_id;
    std::string name;
    int lifetime_days = 28;
    bool list = false;
    std::string withdrawn_id;
};

std::string state_of(const nlohmann::json& share) {
    if (share.at("withdrawn").get<bool>()) return "withdrawn";
    const auto expires_at_ms = share.at("expires_at_ms").get<std::int64_t>();
    return (expires_at_ms <= wall_time_ms() ? "expired " : "until ") + time_text(expires_at_ms);
}

int list_shares(client::RestClient& rest, const std::string& path, const Context& context) {
    const auto shares = rest.list(path, {});
    if (context.json) {
        std::cout << nlohmann::json(shares).dump(2) << '\n';
        return kExitDone;
    }
    std::vector<std::vector<std::string>> rows = {{"ID", "NAME", "CREATED", "LAST USED", "STATE"}};
    for (const auto& share : shares)
        rows.push_back({share.at("id").get<std::string>(),
                        share.at("name").get<std::string>(),
                        time_text(share.at("created_at_ms").get<std::int64_t>()),
                        time_text(share.at("last_used_at_ms").get<std::int64_t>()),
                        state_of(share)});
    std::cout << table_text(rows);
    return kExitDone;
}

// The server's own address counts where it states none that others use.
int create_share(client::RestClient& rest,
                 const std::string& path,
                 const ShareOptions& options,
                 const Context& context) {
    auto share = rest.post(
        path, {{"name", options.name}, {"expires_in_s", options.lifetime_days * 86'400LL}});
    auto url = share.at("url").get<std::string>();
    if (url.starts_with('/')) url.insert(0, rest.account().server.url());
    share["url"] = url;
    if (context.json) {
        std::cout << share.dump(2) << '\n';
        return kExitDone;
    }
    std::cerr << share.at("id").get<std::string>() << ": valid " << state_of(share)
              << "; the address is not shown again\n";
    std::cout << url << '\n';
    return kExitDone;
}

}  // namespace

void add_share(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand(
        "share", "create a link by which others read the result of a job; list and withdraw them");
    auto options = std::make_shared<ShareOptions>();
    command->add_option("job", options->job_id, "id of the job")->required();
    add_server_options(*command, options->server);
    command->add_option("--name", options->name, "for whom the link is");
    command->add_option("--expires-days", options->lifetime_days, "days until the link expires")
        ->capture_default_str()
        ->check(CLI::Range(1, 366));
    auto* list = command->add_flag("--list", options->list, "list the links of the job");
    command
        ->add_option("--withdraw", options->withdrawn_id, "id of a link: it opens nothing any more")
        ->excludes(list);
    command->callback([options, &context] {
        context.command = [options, &context] {
            client::RestClient rest(account_of(options->server));
            const std::string path = client::job_path(options->job_id) + "/shares";
            if (options->list) return list_shares(rest, path, context);
            if (options->withdrawn_id.empty()) return create_share(rest, path, *options, context);
            rest.remove(path + "/" + client::percent_encode(options->withdrawn_id));
            return kExitDone;
        };
    });
}

}  // namespace divemesh::cli
