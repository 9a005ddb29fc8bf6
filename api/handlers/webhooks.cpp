#include "api/handlers/webhooks.hpp"

#include <algorithm>
#include <set>

#include "api/audit.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/preconditions.hpp"
#include "api/webhook_signature.hpp"
#include "api/webhook_target.hpp"
#include "schemas/json.hpp"
#include "storage/ids.hpp"
#include "storage/webhook_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kSecretBytes = 32;

// Checks what can be checked of an address before its name is resolved; the rest is checked each
// time an event is sent.
void check_target(const std::string& url, const AllowedNetworks& allowed) {
    const WebhookTarget target = parse_webhook_url(url);
    boost::system::error_code is_name;
    const auto address = boost::asio::ip::make_address(target.host, is_name);
    const bool ours = !is_name && allowed.contains(address);
    if (!is_name && !ours && !is_public(address))
        throw Error(ErrorCode::InvalidArgument,
                    "\"url\" leads to an address that webhooks may not reach: start the server "
                    "with --webhook-network to allow it");
    if (!target.tls && !ours)
        throw Error(ErrorCode::InvalidArgument, "\"url\" must begin with https://");
}

Webhook webhook_request(const Request& request, const ServiceLimits& limits) {
    const auto body = json_body(request, {"url", "project", "topics"});
    Webhook wanted;
    wanted.url = value_or<std::string>(body, "url", "");
    wanted.project = value_or<std::string>(body, "project", "default");
    const auto topics = value_or<std::set<std::string>>(
        body, "topics", std::set<std::string>(kWebhookTopics.begin(), kWebhookTopics.end()));
    for (const std::string& topic : topics)
        if (std::find(kWebhookTopics.begin(), kWebhookTopics.end(), topic) == kWebhookTopics.end())
            throw Error(ErrorCode::InvalidArgument,
                        "unknown topic \"" + topic + "\" (known: upload, dive, job, sensor)");
    if (topics.empty())
        throw Error(ErrorCode::InvalidArgument, "a webhook needs at least one topic");
    wanted.topics.assign(topics.begin(), topics.end());
    check_target(wanted.url, limits.webhook_networks);
    return wanted;
}

}  // namespace

Awaitable<Response> list_webhooks(Request request, Services services) {
    auto read = [](const Request&, storage::Catalog& catalog) {
        return storage::WebhookStore(catalog).list();
    };
    return get_list(std::move(request), services, read);
}

Awaitable<Response> create_webhook(Request request, Services services) {
    const std::string secret = webhook_secret(storage::random_hex(kSecretBytes));
    auto work = [services, request, wanted = webhook_request(request, services.limits), secret] {
        auto catalog = audited(services, request);
        return storage::WebhookStore(catalog).create(wanted, secret);
    };
    nlohmann::json body = co_await in_pool(services.pool, std::move(work));
    body["secret"] = secret;
    co_return secret_response(body);
}

Awaitable<Response> delete_webhook(Request request, Services services) {
    auto remove = [](const Request& asked, storage::Catalog& catalog) {
        storage::WebhookStore(catalog).remove(asked.parameter("webhook_id"));
    };
    return delete_untagged_resource(std::move(request), services, remove);
}

Awaitable<Response> enable_webhook(Request request, Services services) {
    require_no_tag(request);
    auto enable = [services](const Request& asked) {
        auto catalog = audited(services, asked);
        return storage::WebhookStore(catalog).enable(asked.parameter("webhook_id"));
    };
    return change_resource(std::move(request), services, enable);
}

Awaitable<Response> list_webhook_deliveries(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::WebhookStore(catalog).deliveries(asked.parameter("webhook_id"),
                                                         page_request(asked));
    };
    return get_page(std::move(request), services, read);
}

Awaitable<Response> redeliver_webhook(Request request, Services services) {
    require_no_tag(request);
    auto redeliver = [services](const Request& asked) {
        auto catalog = audited(services, asked);
        return storage::WebhookStore(catalog).redeliver(asked.parameter("webhook_id"),
                                                        asked.parameter("delivery_id"));
    };
    return change_resource(std::move(request), services, redeliver);
}

}  // namespace divemesh::api
