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

// What whoever delivers needs.
struct DueDelivery {
    std::string id;
    std::string webhook_id;
    std::string url;
    std::string secret;
    std::string body;
};

// Webhooks and the outbox of what they are to be told.
class WebhookStore {
public:
    explicit WebhookStore(Catalog& catalog) : catalog_(catalog) {}

    // Puts the event into the outbox of every webhook that wants it, in the transaction that the
    // event is of.
    static void enqueue(soci::session& session, const Event& event);

    // `webhook.id` and the time are set here.
    Webhook create(Webhook webhook, const std::string& secret);
    std::vector<Webhook> list();
    Webhook enable(const std::string& id);  // after it was disabled; throws Error{NotFound}
    void remove(const std::string& id);     // with its deliveries; throws Error{NotFound}

    // Oldest first. Throws Error{NotFound} for a webhook that is none.
    Page<WebhookDelivery> deliveries(const std::string& webhook_id, const PageRequest& page);
    // To be delivered at once, with all its attempts. Throws Error{NotFound}.
    WebhookDelivery redeliver(const std::string& webhook_id, const std::string& delivery_id);

    // Takes the oldest that is due of each webhook but the `busy` ones; others leave them alone for
    // the length of the lease. What waits for a webhook that is disabled goes on waiting.
    std::vector<DueDelivery> claim_due(std::size_t limit,
                                       std::chrono::milliseconds lease,
                                       const std::set<std::string>& busy);
    // The same of one webhook.
    std::optional<DueDelivery> claim_next(const std::string& webhook_id,
                                          std::chrono::milliseconds lease);
    // How an attempt ended; `status` 0: there was no answer. 2xx delivers; 410 gives up and
    // disables the webhook; anything else is tried again, up to a day later, nine times in all.
    // Where nobody answered, the webhook's other deliveries wait for half a minute, too.
    void record(const std::string& delivery_id, int status, const std::string& error);
    // Takes finished ones out of the log.
    void forget_older_than(std::chrono::milliseconds age);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
