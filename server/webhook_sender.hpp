#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ssl/context.hpp>
#include <memory>

#include "api/services.hpp"
#include "storage/webhook_store.hpp"

namespace divemesh::server {

// Empties the outbox: sends what is due, signed as Standard Webhooks has it, a few at a time, and
// records how it ended. A message goes to an address that was checked before (S31): the name is
// resolved once, every address it has must be public or allowed, and that very one is connected to;
// redirects are not followed; the answer's body is not read; 15 s are enough. A message may arrive
// twice when the server is killed meanwhile: receivers tell by webhook-id.
class WebhookSender {
public:
    explicit WebhookSender(const api::Services& services);

    boost::asio::awaitable<void> run();  // until stop()
    void stop() { stopping_ = true; }

private:
    boost::asio::awaitable<void> deliver(storage::DueDelivery due);

    api::Services services_;
    boost::asio::ssl::context tls_;
    std::atomic<int> num_under_way_ = 0;
    std::atomic<bool> stopping_ = false;
};

}  // namespace divemesh::server
