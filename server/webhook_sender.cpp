#include "server/webhook_sender.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <chrono>

#include "api/client/dial.hpp"
#include "api/in_pool.hpp"
#include "api/metrics.hpp"
#include "api/webhook_signature.hpp"
#include "api/webhook_target.hpp"
#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "server/resolve.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;
using namespace std::chrono_literals;

constexpr std::size_t kMaxUnderWay = 64;
constexpr auto kCheckEvery = 500ms;
constexpr auto kResolveTimeout = 5s;
constexpr auto kTimeout = 15s;
constexpr auto kLease = 60s;  // longer than an attempt may take
constexpr std::uint32_t kMaxHeaderBytes = 8 << 10;

struct Outcome {
    int status = 0;
    std::string error;
};

http::request<http::string_body> message_of(const storage::DueDelivery& due,
                                            const api::WebhookTarget& target,
                                            const std::string& public_url) {
    const auto now_s = static_cast<std::int64_t>(std::time(nullptr));
    http::request<http::string_body> message(http::verb::post, target.path, 11);
    const bool v6 = target.host.find(':') != std::string::npos;
    message.set(http::field::host,
                (v6 ? "[" + target.host + "]" : target.host) + ":" + target.port);
    message.set(http::field::user_agent, "divemesh");
    message.set(http::field::content_type, "application/json");
    message.set("webhook-id", due.id);
    message.set("webhook-timestamp", std::to_string(now_s));
    message.set("webhook-signature", api::webhook_signature(due.secret, due.id, now_s, due.body));
    if (!public_url.empty()) message.set("divemesh-server", public_url);
    message.keep_alive(false);
    message.body() = due.body;
    message.prepare_payload();
    return message;
}

void check_addresses(const Addresses& found,
                     const api::WebhookTarget& target,
                     const api::AllowedNetworks& allowed) {
    for (const tcp::endpoint& endpoint : found) {
        const auto address = endpoint.address();
        if (allowed.contains(address)) continue;
        if (!api::is_public(address))
            throw Error(ErrorCode::Forbidden,
                        "the URL leads to an address that webhooks may not reach");
        if (!target.tls)
            throw Error(ErrorCode::Forbidden, "outside of the allowed networks only https is used");
    }
}

template <typename Stream>
asio::awaitable<int> exchange(Stream& stream, http::request<http::string_body> message) {
    co_await http::async_write(stream, message, asio::use_awaitable);
    beast::flat_buffer buffer;
    http::response_parser<http::empty_body> answer;
    answer.header_limit(kMaxHeaderBytes);
    co_await http::async_read_header(stream, buffer, answer, asio::use_awaitable);
    co_return static_cast<int>(answer.get().result_int());
}

asio::awaitable<int> send(storage::DueDelivery due,
                          api::Services services,
                          asio::ssl::context* tls) {
    const auto executor = co_await asio::this_coro::executor;
    const api::WebhookTarget target = api::parse_webhook_url(due.url);
    auto message = message_of(due, target, services.limits.public_url);
    const Addresses found = co_await resolve_within(target.host, target.port, kResolveTimeout);
    check_addresses(found, target, services.limits.webhook_networks);
    api::client::Stream::Tls stream(executor, *tls);
    auto& plain = beast::get_lowest_layer(stream);
    plain.expires_after(kTimeout);
    co_await plain.async_connect(found, asio::use_awaitable);
    if (!target.tls) co_return co_await exchange(plain, std::move(message));
    api::client::expect_host(stream, target.host);
    co_await stream.async_handshake(asio::ssl::stream_base::client, asio::use_awaitable);
    co_return co_await exchange(stream, std::move(message));
}

asio::awaitable<Outcome> attempt(storage::DueDelivery due,
                                 api::Services services,
                                 asio::ssl::context* tls) {
    Outcome outcome;
    try {
        outcome.status = co_await send(std::move(due), services, tls);
        if (outcome.status < 200 || outcome.status > 299)
            outcome.error = "the receiver answered " + std::to_string(outcome.status);
    } catch (const std::exception& error) {
        outcome.error = error.what();
    }
    co_return outcome;
}

}  // namespace

WebhookSender::WebhookSender(const api::Services& services)
    : services_(services), tls_(api::client::believing_context()) {}

asio::awaitable<void> WebhookSender::run() {
    const auto executor = co_await asio::this_coro::executor;
    asio::steady_timer pause(executor);
    while (!stopping_) {
        try {
            auto claim = [this, busy = busy()] {
                return storage::WebhookStore(services_.catalog)
                    .claim_due(kMaxUnderWay - busy.size(), kLease, busy);
            };
            const auto due = co_await api::in_pool(services_.pool, std::move(claim));
            for (const auto& delivery : due) {
                {
                    const std::lock_guard lock(mutex_);
                    busy_.insert(delivery.webhook_id);
                }
                asio::co_spawn(asio::make_strand(executor), deliver_all(delivery), asio::detached);
            }
        } catch (const std::exception& error) {
            log_warning({{"event", "webhooks_unavailable"}, {"what", error.what()}});
        }
        pause.expires_after(kCheckEvery);
        co_await pause.async_wait(asio::use_awaitable);
    }
}

std::set<std::string> WebhookSender::busy() {
    const std::lock_guard lock(mutex_);
    return busy_;
}

asio::awaitable<void> WebhookSender::deliver_all(storage::DueDelivery due) {
    const std::string webhook = due.webhook_id;
    try {
        std::optional<storage::DueDelivery> next = std::move(due);
        while (next) {  // g++ 12 miscompiles a co_await in the condition of a loop
            const bool delivered = co_await deliver(std::move(*next));
            next.reset();
            if (!delivered || stopping_) break;
            auto claim = [this, webhook] {
                return storage::WebhookStore(services_.catalog).claim_next(webhook, kLease);
            };
            next = co_await api::in_pool(services_.pool, std::move(claim));
        }
    } catch (const std::exception& error) {
        log_warning({{"event", "webhooks_unavailable"}, {"what", error.what()}});
    }
    const std::lock_guard lock(mutex_);
    busy_.erase(webhook);
}

asio::awaitable<bool> WebhookSender::deliver(storage::DueDelivery due) {
    const Outcome outcome = co_await attempt(due, services_, &tls_);
    if (!outcome.error.empty()) ++services_.metrics.webhook_failures;
    try {
        auto record = [this, id = due.id, outcome] {
            storage::WebhookStore(services_.catalog).record(id, outcome.status, outcome.error);
        };
        co_await api::in_pool(services_.pool, std::move(record));
    } catch (const std::exception& error) {  // it is due again when its lease ends
        log_warning({{"event", "webhook_not_recorded"}, {"id", due.id}, {"what", error.what()}});
    }
    log_info({{"event", "webhook"},
              {"id", due.id},
              {"status", outcome.status},
              {"error", outcome.error}});
    co_return outcome.status != 0;
}

}  // namespace divemesh::server
