#pragma once

#include <chrono>
#include <optional>
#include <set>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "schemas/event.hpp"
#include "schemas/webhook.hpp"
#include "storage/catalog.hpp"
#include "storage/page.hpp"

namespace divemesh::storage {

// A due delivery, with what the sender needs.
struct DueDelivery {
    std::string id;
    std::string webhook_id;
    std::string url;
    std::string secret;
    std::string body;
};

// Webhooks and the outbox of their deliveries.
class WebhookStore {
public:
    explicit WebhookStore(Catalog& catalog) : catalog_(catalog) {}

    // Puts the event into the outbox of every webhook that subscribes to it, in the event's
    // transaction.
    static void enqueue(soci::session& session, const Event& event);

    // Creates a webhook and sets its `id` and time.
    Webhook create(Webhook webhook, const std::string& secret);
    std::vector<Webhook> list();
    Webhook enable(const std::string& id);  // after it was disabled; throws Error{NotFound}
    void remove(const std::string& id);     // with its deliveries; throws Error{NotFound}

    // Returns deliveries, oldest first. Throws Error{NotFound} for an unknown webhook.
    Page<WebhookDelivery> deliveries(const std::string& webhook_id, const PageRequest& page);
    // Makes a delivery due at once, with all its attempts. Throws Error{NotFound}.
    WebhookDelivery redeliver(const std::string& webhook_id, const std::string& delivery_id);

    // Claims the oldest due delivery of each webhook except the `busy` ones; other callers skip
    // these for the length of the lease. Deliveries of a disabled webhook keep waiting.
    std::vector<DueDelivery> claim_due(std::size_t limit,
                                       std::chrono::milliseconds lease,
                                       const std::set<std::string>& busy);
    // Claims the next due delivery of one webhook.
    std::optional<DueDelivery> claim_next(const std::string& webhook_id,
                                          std::chrono::milliseconds lease);
    // Records the outcome of an attempt; `status` 0: no response. 2xx: delivered; 410: gives up and
    // disables the webhook; otherwise it is retried, up to a day later, nine times in all. Without
    // a response the webhook's other deliveries wait for half a minute, too.
    void record(const std::string& delivery_id, int status, const std::string& error);
    // Removes finished deliveries from the log.
    void forget_older_than(std::chrono::milliseconds age);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
