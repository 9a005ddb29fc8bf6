#include "api/audit.hpp"

#include <nlohmann/json.hpp>

#include "api/in_pool.hpp"
#include "schemas/log.hpp"
#include "storage/event_store.hpp"

namespace divemesh::api {
namespace {

Event event_of(const Request& request,
               std::optional<std::int64_t> uploaded_bytes,
               const std::string& type = "audit.write") {
    Event event{.topic = "audit", .subject = request.token.id, .type = type};
    event.data = {{"token", request.token.id},
                  {"token_name", request.token.name},
                  {"token_project", request.token.project},
                  {"method", std::string(http::to_string(request.method))},
                  {"path", request.path},
                  {"request_id", request.id},
                  {"peer", request.peer}};
    if (uploaded_bytes) event.data["uploaded_bytes"] = *uploaded_bytes;
    return event;
}

Event event_of(const std::string& who, const std::string& what) {
    Request nobodys{.path = what};
    nobodys.token.name = who;
    Event event = event_of(nobodys, std::nullopt);
    event.data["method"] = "";
    return event;
}

storage::Catalog with_event(const storage::Catalog& catalog, Event event) {
    return catalog.with_audit([event = std::move(event)](soci::session& session) {
        storage::EventStore::append(session, event);
    });
}

// Writes the event of something that has happened already.
void write_after(const Services& services, const Event& event) {
    try {
        services.catalog.transaction(
            [&](soci::session& session) { storage::EventStore::append(session, event); });
    } catch (const std::exception& error) {
        log_error({{"event", "audit_not_written"}, {"what", error.what()}, {"data", event.data}});
    }
}

}  // namespace

storage::Catalog audited(const Services& services,
                         const Request& request,
                         std::optional<std::int64_t> uploaded_bytes) {
    return with_event(services.catalog, event_of(request, uploaded_bytes));
}

storage::Catalog audited(const storage::Catalog& catalog,
                         const std::string& who,
                         const std::string& what) {
    return with_event(catalog, event_of(who, what));
}

void append_audit_event(soci::session& session, const std::string& who, const std::string& what) {
    storage::EventStore::append(session, event_of(who, what));
}

void audit_uploaded(const Services& services, const Request& request, std::int64_t num_bytes) {
    write_after(services, event_of(request, num_bytes));
}

Awaitable<void> audit_visit(Request request, Services services) {
    if (request.token.shared_job.empty() ||
        !services.share_visits.is_new(request.token.id, request.peer))
        co_return;
    auto work = [services, event = event_of(request, std::nullopt, "audit.visit")] {
        write_after(services, event);
    };
    co_await in_pool(services.pool, std::move(work));
}

}  // namespace divemesh::api
