#include "storage/event_store.hpp"

#include "storage/sql.hpp"
#include "storage/webhook_store.hpp"

namespace divemesh::storage {
namespace {

struct EventRow {
    Event event;
    std::string data;

    void define(soci::statement& statement) {
        define_columns(statement,
                       event.sequence,
                       event.time_ms,
                       event.project,
                       event.topic,
                       event.subject,
                       event.type,
                       data);
    }
    Event value() const {
        Event value = event;
        value.data = nlohmann::json::parse(data);
        return value;
    }
};

void insert(soci::session& session, Event& event) {
    event.time_ms = Catalog::now_ms(session);
    const std::string data = to_text(event.data);
    execute(session, "UPDATE event_sequence SET newest = newest + 1");
    session << "SELECT newest FROM event_sequence", soci::into(event.sequence);
    execute(session,
            "INSERT INTO events (sequence, time_ms, project, topic, subject, type, data)"
            " VALUES (:sequence, :now, :project, :topic, :subject, :type, :data)",
            soci::use(event.sequence, "sequence"),
            soci::use(event.time_ms, "now"),
            soci::use(event.project, "project"),
            soci::use(event.topic, "topic"),
            soci::use(event.subject, "subject"),
            soci::use(event.type, "type"),
            soci::use(data, "data"));
}

}  // namespace

void EventStore::append(soci::session& session, Event event) {
    insert(session, event);
    WebhookStore::enqueue(session, event);
}

void EventStore::replace(soci::session& session, Event event) {
    execute(session,
            "DELETE FROM events WHERE subject = :subject AND type = :type",
            soci::use(event.subject, "subject"),
            soci::use(event.type, "type"));
    insert(session, event);
}

std::vector<Event> EventStore::since(std::int64_t sequence, const std::string& project, int limit) {
    std::vector<Event> events;
    catalog_.read([&](soci::session& session) {
        events = select_all<EventRow>(
            session,
            "SELECT sequence, time_ms, project, topic, subject, type, data FROM events"
            " WHERE sequence > :sequence AND (:project = '' OR project = :project)"
            " ORDER BY sequence LIMIT :limit",
            soci::use(sequence, "sequence"),
            soci::use(project, "project"),
            soci::use(limit, "limit"));
    });
    return events;
}

std::int64_t EventStore::newest_sequence() {
    std::int64_t newest = 0;
    catalog_.read([&](soci::session& session) {
        session << "SELECT newest FROM event_sequence", soci::into(newest);
    });
    return newest;
}

std::int64_t EventStore::oldest_sequence() {
    std::int64_t oldest = 0;
    catalog_.read([&](soci::session& session) {
        session << "SELECT COALESCE(MIN(sequence), 0) FROM events", soci::into(oldest);
    });
    return oldest;
}

}  // namespace divemesh::storage
