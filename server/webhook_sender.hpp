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

// Sends the due deliveries of the outbox, signed as in Standard Webhooks, and records the outcome.
// Each webhook gets one message at a time, so a dead receiver does not delay the others. A message
// goes only to a checked address: the name is resolved once, every address of it must be
// public or allowed, and the connection goes to one of exactly these. Redirects are not followed
// and the response's body is not read. The name may take 5 s, the rest 15 s. A message may arrive
// twice if the server is killed meanwhile: receivers tell by webhook-id.
class WebhookSender {
public:
    explicit WebhookSender(const api::Services& services);

    boost::asio::awaitable<void> run();  // until stop()
    void stop() { stopping_ = true; }

private:
    // Delivers `due` and the further due messages of its webhook.
    boost::asio::awaitable<void> deliver_all(storage::DueDelivery due);
    boost::asio::awaitable<bool> deliver(storage::DueDelivery due);  // true: it responded
    std::set<std::string> busy();

    api::Services services_;
    boost::asio::ssl::context tls_;
    std::mutex mutex_;
    std::set<std::string> busy_;  // webhooks with a message under way
    std::atomic<bool> stopping_ = false;
};

}  // namespace divemesh::server
