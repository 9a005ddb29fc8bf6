#include <iostream>
#include <memory>
#include <pwd.h>
#include <unistd.h>

#include "api/audit.hpp"
#include "api/browser_session.hpp"
#include "cli/command.hpp"
#include "cli/data_options.hpp"
#include "cli/exit_code.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"
#include "storage/token_store.hpp"

namespace divemesh::cli {
namespace {

struct TokenOptions {
    DataOptions data;
    std::string name;
    std::string project = "default";
    std::vector<std::string> scopes = {"dives:read", "dives:write", "jobs:write"};
    std::string sensor;
    int lifetime_days = 0;
    std::string id;
    std::string server = "http://127.0.0.1:8080";
};

// Returns the name of the user, as the system knows it.
std::string by_whom() {
    const passwd* user = getpwuid(getuid());
    return std::string("command line, ") +
           (user != nullptr ? user->pw_name : std::to_string(getuid()));
}

int create_token(const TokenOptions& options, const Context& context) {
    const storage::Catalog catalog(catalog_url(options.data));
    auto noted = api::audited(catalog, by_whom(), "token create " + options.name);
    const auto created = storage::TokenStore(noted).create(
        {.name = options.name,
         .project = options.project,
         .scopes = options.scopes,
         .sensor = options.sensor,
         .lifetime = options.lifetime_days * std::chrono::hours(24)});
    if (context.json) {
        nlohmann::json json = created.token;
        json["secret"] = created.secret;
        std::cout << json.dump(2) << '\n';
    } else {
        std::cerr << created.token.id << ": store the secret now, it is not shown again\n";
        std::cout << created.secret << '\n';
    }
    return kExitDone;
}

int list_tokens(const TokenOptions& options, const Context& context) {
    storage::Catalog catalog(catalog_url(options.data), storage::Opening::ExistingOnly);
    const auto tokens = storage::TokenStore(catalog).list();
    if (context.json) {
        std::cout << nlohmann::json(tokens).dump(2) << '\n';
        return kExitDone;
    }
    std::vector<std::vector<std::string>> rows = {
        {"ID", "NAME", "PROJECT", "SCOPES", "CREATED", "LAST USED", "STATE"}};
    for (const auto& token : tokens) {
        std::string scopes;
        for (const auto& scope : token.scopes) scopes += (scopes.empty() ? "" : ",") + scope;
        rows.push_back({token.id,
                        token.name,
                        token.project,
                        scopes,
                        time_text(token.created_at_ms),
                        time_text(token.last_used_at_ms),
                        token.revoked             ? "revoked"
                        : token.expires_at_ms > 0 ? "until " + time_text(token.expires_at_ms)
                                                  : "valid"});
    }
    std::cout << table_text(rows);
    return kExitDone;
}

int revoke_token(const TokenOptions& options) {
    const storage::Catalog catalog(catalog_url(options.data), storage::Opening::ExistingOnly);
    auto noted = api::audited(catalog, by_whom(), "token revoke " + options.id);
    storage::TokenStore(noted).revoke(options.id);
    return kExitDone;
}

int sign_in(const TokenOptions& options) {
    const storage::Catalog catalog(catalog_url(options.data), storage::Opening::ExistingOnly);
    const std::string path = api::make_sign_in_path(catalog, options.id, by_whom());
    std::cerr << "open this address in a browser: it signs in once, within 15 minutes\n";
    std::cout << options.server << path << '\n';
    return kExitDone;
}

void add_sign_in(CLI::App& command,
                 const std::shared_ptr<TokenOptions>& options,
                 Context& context) {
    auto* sign_in_command = command.add_subcommand(
        "sign-in", "print an address that signs a browser in to the web page, once");
    add_data_options(*sign_in_command, options->data);
    sign_in_command->add_option(
        "token", options->id, "id of the token; default: the oldest one with the scope admin");
    sign_in_command->add_option("--server", options->server, "address of the server")
        ->capture_default_str();
    sign_in_command->callback(
        [options, &context] { context.command = [options] { return sign_in(*options); }; });
}

}  // namespace

void add_token(CLI::App& app, Context& context) {
    auto* command =
        app.add_subcommand("token", "create, list and revoke tokens, in the catalog of a server");
    command->require_subcommand(1);
    auto options = std::make_shared<TokenOptions>();

    auto* create = command->add_subcommand("create", "create a token and print its secret once");
    add_data_options(*create, options->data);
    create->add_option("--name", options->name, "name of the token, to recognise it")->required();
    create->add_option("--project", options->project, "project whose dives it can access")
        ->capture_default_str();
    create
        ->add_option(
            "--scope", options->scopes, "scopes of the token; sensor:push must be the only one")
        ->delimiter(',')
        ->capture_default_str();
    create->add_option("--sensor", options->sensor, "id of the sensor, for the scope sensor:push");
    create
        ->add_option("--expires-days",
                     options->lifetime_days,
                     "days until the token expires; 0: valid until it is revoked")
        ->capture_default_str()
        ->check(CLI::Range(0, 3660));
    create->callback([options, &context] {
        context.command = [options, &context] { return create_token(*options, context); };
    });

    auto* list = command->add_subcommand("list", "list all tokens, without their secrets");
    add_data_options(*list, options->data);
    list->callback([options, &context] {
        context.command = [options, &context] { return list_tokens(*options, context); };
    });

    add_sign_in(*command, options, context);

    auto* revoke = command->add_subcommand("revoke", "revoke a token");
    add_data_options(*revoke, options->data);
    revoke->add_option("token", options->id, "id of the token")->required();
    revoke->callback(
        [options, &context] { context.command = [options] { return revoke_token(*options); }; });
}

}  // namespace divemesh::cli
