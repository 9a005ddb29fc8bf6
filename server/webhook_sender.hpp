#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ssl/context.hpp>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "api/services.hpp"
#include "storage/webhook_store.hpp"

namespace divemesh::server {

// Empties the outbox: sends what is due, signed as Standard Webhooks has it, one message at a time
// to each webhook, so that a dead receiver delays nobody else, and records how it ended. A message
// goes to an address that was checked before (S31): the name is resolved once, every address it has
// must be public or allowed, and that very one is connected to; redirects are not followed; the
// answer's body is not read; 5 s have to do for the name and 15 s for the rest. A message may
// arrive twice when the server is killed meanwhile: receivers tell by webhook-id.
class WebhookSender {
public:
    explicit WebhookSender(const api::Services& services);

    boost::asio::awaitable<void> run();  // until stop()
    void stop() { stopping_ = true; }

private:
    // And what else is due of its webhook.
    boost::asio::awaitable<void> deliver_all(storage::DueDelivery due);
    boost::asio::awaitable<bool> deliver(storage::DueDelivery due);  // whether somebody answered
    std::set<std::string> busy();

    api::Services services_;
    boost::asio::ssl::context tls_;
    std::mutex mutex_;
    std::set<std::string> busy_;  // webhooks with a message under way
    std::atomic<bool> stopping_ = false;
};

}  // namespace divemesh::server
