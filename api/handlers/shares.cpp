#include "api/handlers/shares.hpp"

#include "api/handlers/resource.hpp"
#include "api/public_url.hpp"
#include "api/visible.hpp"
#include "storage/share_store.hpp"

namespace divemesh::api {
namespace {

storage::NewShare share_request(const Request& request) {
    const auto body = json_body(request, {"name", "expires_in_s"});
    storage::NewShare wanted{.name = value_or<std::string>(body, "name", "")};
    wanted.lifetime =
        std::chrono::seconds(value_or<std::int64_t>(body, "expires_in_s", wanted.lifetime.count()));
    return wanted;
}

}  // namespace

Awaitable<Response> list_shares(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::ShareStore(catalog).list(visible_job(asked, catalog).id);
    };
    return get_list(std::move(request), services, read);
}

// A browser sends no server what follows the # of an address, so no log and no referrer has it.
Awaitable<Response> create_share(Request request, Services services) {
    auto work = [services, request] {
        const Job job = visible_job(request, services.catalog);
        auto catalog = audited(services, request);
        return storage::ShareStore(catalog).create(job.id, share_request(request));
    };
    const auto created = co_await in_pool(services.pool, std::move(work));
    nlohmann::json body = created.share;
    body["secret"] = created.secret;
    body["url"] = public_address(services.limits, "/share#" + created.secret);
    co_return secret_response(body);
}

Awaitable<Response> withdraw_share(Request request, Services services) {
    auto withdraw = [services](const Request& asked, storage::Catalog& catalog) {
        const Job job = visible_job(asked, services.catalog);
        storage::ShareStore(catalog).withdraw(job.id, asked.parameter("share_id"));
        services.tokens.clear();
    };
    return delete_untagged_resource(std::move(request), services, withdraw);
}

}  // namespace divemesh::api
