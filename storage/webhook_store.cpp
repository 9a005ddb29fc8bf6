#include "storage/webhook_store.hpp"

#include <array>
#include <ctime>
#include <sstream>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/ids.hpp"
#include "storage/page_cursor.hpp"
#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

// The pause until the next attempt, after the first, second ... failure.
constexpr std::array<std::int64_t, 8> kPausesSeconds = {
    5, 300, 1800, 7200, 18'000, 36'000, 50'400, 86'400};
constexpr std::int64_t kSilencePause_ms = 30'000;

#define WEBHOOK_COLUMNS "id, project, url, topics, state, created_at_ms"
#define DELIVERY_COLUMNS                                                              \
    "id, webhook_id, type, state, num_attempts, next_at_ms, last_status, last_error," \
    " created_at_ms, finished_at_ms"

struct WebhookRow {
    Webhook webhook;
    std::string topics;
    std::string state;

    void define(soci::statement& statement) {
        define_columns(statement,
                       webhook.id,
                       webhook.project,
                       webhook.url,
                       topics,
                       state,
                       webhook.created_at_ms);
    }
    Webhook value() const {
        Webhook value = webhook;
        std::istringstream words(topics);
        for (std::string topic; words >> topic;) value.topics.push_back(topic);
        value.enabled = state == "enabled";
        return value;
    }
};

struct DeliveryRow {
    WebhookDelivery delivery;

    void define(soci::statement& statement) {
        define_columns(statement,
                       delivery.id,
                       delivery.webhook_id,
                       delivery.type,
                       delivery.state,
                       delivery.num_attempts,
                       delivery.next_at_ms,
                       delivery.last_status,
                       delivery.last_error,
                       delivery.created_at_ms,
                       delivery.finished_at_ms);
    }
    WebhookDelivery value() const { return delivery; }
};

struct DueRow {
    DueDelivery due;

    void define(soci::statement& statement) {
        define_columns(statement, due.id, due.webhook_id, due.url, due.secret, due.body);
    }
    DueDelivery value() const { return due; }
};

Webhook read_webhook(soci::session& session, const std::string& id) {
    auto webhook = select_one<WebhookRow>(
        session, "SELECT " WEBHOOK_COLUMNS " FROM webhooks WHERE id = :id", soci::use(id, "id"));
    if (!webhook) throw Error(ErrorCode::NotFound, "no webhook " + id);
    return std::move(*webhook);
}

// Returns e.g. 2026-11-20T14:03:05Z.
std::string iso_time(std::int64_t unix_ms) {
    const std::time_t seconds = unix_ms / 1000;
    std::tm parts{};
    gmtime_r(&seconds, &parts);
    char text[32];
    return std::string(text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts));
}

// Adds up to a tenth at random, so that a receiver that comes back does not get all deliveries at
// once.
std::int64_t pause_ms(int num_attempts) {
    const std::int64_t pause = kPausesSeconds[static_cast<std::size_t>(num_attempts - 1)] * 1000;
    const auto random = std::stoul(random_hex(2), nullptr, 16);
    return pause + pause / 10 * static_cast<std::int64_t>(random) / 0x10000;
}

void finish(soci::session& session,
            const WebhookDelivery& delivery,
            const std::string& state,
            std::int64_t now_ms) {
    execute(session,
            "UPDATE webhook_deliveries SET state = :state, finished_at_ms = :now WHERE id = :id",
            soci::use(state, "state"),
            soci::use(now_ms, "now"),
            soci::use(delivery.id, "id"));
}

const std::string kSelectDue =
    "SELECT webhook_deliveries.id, webhook_id, url, secret, body"
    " FROM webhook_deliveries, webhooks WHERE webhooks.id = webhook_id"
    " AND webhook_deliveries.state = 'waiting' AND webhooks.state = 'enabled'"
    " AND next_at_ms <= :now";

std::vector<DueDelivery> oldest_of_each(soci::session& session, std::size_t limit) {
    const std::int64_t now_ms = Catalog::now_ms(session);
    const auto max_num_rows = static_cast<std::int64_t>(limit);
    return select_all<DueRow>(
        session,
        kSelectDue +
            " AND webhook_deliveries.id = (SELECT first.id FROM webhook_deliveries AS first"
            " WHERE first.webhook_id = webhooks.id AND first.state = 'waiting'"
            " AND first.next_at_ms <= :now ORDER BY first.next_at_ms, first.id LIMIT 1)"
            " ORDER BY next_at_ms, webhook_deliveries.id LIMIT :limit",
        soci::use(now_ms, "now"),
        soci::use(max_num_rows, "limit"));
}

void lease_delivery(soci::session& session,
                    const DueDelivery& delivery,
                    std::chrono::milliseconds lease) {
    const std::int64_t until_ms = Catalog::now_ms(session) + lease.count();
    execute(session,
            "UPDATE webhook_deliveries SET next_at_ms = :until,"
            " num_attempts = num_attempts + 1 WHERE id = :id",
            soci::use(until_ms, "until"),
            soci::use(delivery.id, "id"));
}

// Without a response the other due deliveries wait as well, and do not count as tried.
void postpone_all(soci::session& session, const std::string& webhook_id, std::int64_t now_ms) {
    const std::int64_t later_ms = now_ms + kSilencePause_ms;
    execute(session,
            "UPDATE webhook_deliveries SET next_at_ms = :later"
            " WHERE webhook_id = :webhook AND state = 'waiting' AND next_at_ms < :later",
            soci::use(later_ms, "later"),
            soci::use(webhook_id, "webhook"));
}

}  // namespace

void WebhookStore::enqueue(soci::session& session, const Event& event) {
    const auto webhooks =
        select_all<TextRow>(session,
                            "SELECT id FROM webhooks WHERE state = 'enabled' AND project = :project"
                            " AND topics LIKE '% ' || :topic || ' %'",
                            soci::use(event.project, "project"),
                            soci::use(event.topic, "topic"));
    if (webhooks.empty()) return;
    const std::string body =
        to_text({{"type", event.type}, {"timestamp", iso_time(event.time_ms)}, {"data", event}});
    for (const std::string& webhook : webhooks) {
        const std::string id = "msg_" + webhook + "_" + std::to_string(event.sequence);
        execute(session,
                "INSERT INTO webhook_deliveries"
                " (id, webhook_id, type, body, next_at_ms, created_at_ms)"
                " VALUES (:id, :webhook, :type, :body, :now, :now)",
                soci::use(id, "id"),
                soci::use(webhook, "webhook"),
                soci::use(event.type, "type"),
                soci::use(body, "body"),
                soci::use(event.time_ms, "now"));
    }
}

Webhook WebhookStore::create(Webhook webhook, const std::string& secret) {
    webhook.id = new_id("webhook");
    std::string topics = " ";
    for (const std::string& topic : webhook.topics) topics += topic + " ";
    catalog_.transaction([&](soci::session& session) {
        webhook.created_at_ms = Catalog::now_ms(session);
        execute(session,
                "INSERT INTO webhooks (id, project, url, secret, topics, created_at_ms)"
                " VALUES (:id, :project, :url, :secret, :topics, :now)",
                soci::use(webhook.id, "id"),
                soci::use(webhook.project, "project"),
                soci::use(webhook.url, "url"),
                soci::use(secret, "secret"),
                soci::use(topics, "topics"),
                soci::use(webhook.created_at_ms, "now"));
    });
    return webhook;
}

std::vector<Webhook> WebhookStore::list() {
    std::vector<Webhook> webhooks;
    catalog_.read([&](soci::session& session) {
        webhooks = select_all<WebhookRow>(
            session, "SELECT " WEBHOOK_COLUMNS " FROM webhooks ORDER BY created_at_ms, id");
    });
    return webhooks;
}

Webhook WebhookStore::enable(const std::string& id) {
    Webhook webhook;
    catalog_.transaction([&](soci::session& session) {
        execute(
            session, "UPDATE webhooks SET state = 'enabled' WHERE id = :id", soci::use(id, "id"));
        webhook = read_webhook(session, id);
    });
    return webhook;
}

void WebhookStore::remove(const std::string& id) {
    catalog_.transaction([&](soci::session& session) {
        read_webhook(session, id);
        execute(
            session, "DELETE FROM webhook_deliveries WHERE webhook_id = :id", soci::use(id, "id"));
        execute(session, "DELETE FROM webhooks WHERE id = :id", soci::use(id, "id"));
    });
}

Page<WebhookDelivery> WebhookStore::deliveries(const std::string& webhook_id,
                                               const PageRequest& page) {
    const PageStart start = page_start(page);
    std::vector<WebhookDelivery> rows;
    catalog_.read([&](soci::session& session) {
        read_webhook(session, webhook_id);
        rows = select_all<DeliveryRow>(
            session,
            "SELECT " DELIVERY_COLUMNS
            " FROM webhook_deliveries WHERE webhook_id = :webhook"
            " AND (created_at_ms > :age OR (created_at_ms = :age AND id > :id))"
            " ORDER BY created_at_ms, id LIMIT :limit",
            soci::use(webhook_id, "webhook"),
            soci::use(start.created_at_ms, "age"),
            soci::use(start.id, "id"),
            soci::use(start.limit_plus_one, "limit"));
    });
    return make_page(std::move(rows), page);
}

WebhookDelivery WebhookStore::redeliver(const std::string& webhook_id,
                                        const std::string& delivery_id) {
    std::optional<WebhookDelivery> delivery;
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        delivery = select_one<DeliveryRow>(
            session,
            "UPDATE webhook_deliveries SET state = 'waiting', num_attempts = 0, next_at_ms = :now,"
            " finished_at_ms = 0 WHERE id = :id AND webhook_id = :webhook"
            " RETURNING " DELIVERY_COLUMNS,
            soci::use(now_ms, "now"),
            soci::use(delivery_id, "id"),
            soci::use(webhook_id, "webhook"));
    });
    if (!delivery) throw Error(ErrorCode::NotFound, "no delivery " + delivery_id);
    return std::move(*delivery);
}

std::vector<DueDelivery> WebhookStore::claim_due(std::size_t limit,
                                                 std::chrono::milliseconds lease,
                                                 const std::set<std::string>& busy) {
    std::vector<DueDelivery> due;
    const auto look = [&](soci::session& session) {
        // The busy webhooks may be among those that are read.
        due = oldest_of_each(session, limit + busy.size());
        std::erase_if(due,
                      [&](const DueDelivery& found) { return busy.contains(found.webhook_id); });
        if (due.size() > limit) due.resize(limit);
    };
    catalog_.read(look);
    if (due.empty()) return due;  // avoids an empty write
    catalog_.transaction([&](soci::session& session) {
        look(session);
        for (const DueDelivery& delivery : due) lease_delivery(session, delivery, lease);
    });
    return due;
}

std::optional<DueDelivery> WebhookStore::claim_next(const std::string& webhook_id,
                                                    std::chrono::milliseconds lease) {
    std::optional<DueDelivery> due;
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        due = select_one<DueRow>(session,
                                 kSelectDue +
                                     " AND webhook_id = :webhook"
                                     " ORDER BY next_at_ms, webhook_deliveries.id LIMIT 1",
                                 soci::use(now_ms, "now"),
                                 soci::use(webhook_id, "webhook"));
        if (due) lease_delivery(session, *due, lease);
    });
    return due;
}

void WebhookStore::record(const std::string& delivery_id, int status, const std::string& error) {
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t now_ms = Catalog::now_ms(session);
        const auto delivery = select_one<DeliveryRow>(
            session,
            "UPDATE webhook_deliveries SET last_status = :status, last_error = :error"
            " WHERE id = :id AND state = 'waiting' RETURNING " DELIVERY_COLUMNS,
            soci::use(status, "status"),
            soci::use(error, "error"),
            soci::use(delivery_id, "id"));
        if (!delivery) return;  // removed meanwhile
        if (status >= 200 && status < 300) return finish(session, *delivery, "delivered", now_ms);
        if (status == 410)
            execute(session,
                    "UPDATE webhooks SET state = 'disabled' WHERE id = :id",
                    soci::use(delivery->webhook_id, "id"));
        const auto num_pauses = static_cast<int>(kPausesSeconds.size());
        if (status == 410 || delivery->num_attempts > num_pauses)
            return finish(session, *delivery, "failed", now_ms);
        const std::int64_t next_at_ms = now_ms + pause_ms(std::max(delivery->num_attempts, 1));
        execute(session,
                "UPDATE webhook_deliveries SET next_at_ms = :next WHERE id = :id",
                soci::use(next_at_ms, "next"),
                soci::use(delivery_id, "id"));
        if (status == 0) postpone_all(session, delivery->webhook_id, now_ms);
    });
}

void WebhookStore::forget_older_than(std::chrono::milliseconds age) {
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t before_ms = Catalog::now_ms(session) - age.count();
        execute(session,
                "DELETE FROM webhook_deliveries WHERE state <> 'waiting'"
                " AND finished_at_ms < :before",
                soci::use(before_ms, "before"));
    });
}

}  // namespace divemesh::storage
