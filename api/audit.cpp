#include "api/audit.hpp"

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "storage/event_store.hpp"

namespace divemesh::api {

// Of the pieces that an upload comes in, the last: its creation and its end are changes.
bool is_audited(const Request& request, const Response& response) {
    const bool writes = request.method == verb::post || request.method == verb::put ||
                        request.method == verb::patch || request.method == verb::delete_;
    const bool is_piece = request.method == verb::patch && response.route != nullptr &&
                          response.route->kind == RouteKind::BodyStream;
    if (is_piece && !response.uploaded_bytes) return false;
    const auto status = static_cast<unsigned>(response.status);
    return writes && status >= 200 && status < 300 && response.route != nullptr &&
           !response.route->scope.empty();
}

void write_audit(const Services& services, const Request& request, const Response& response) {
    nlohmann::json data = {{"token", request.token.id},
                           {"token_name", request.token.name},
                           {"token_project", request.token.project},
                           {"method", std::string(http::to_string(request.method))},
                           {"path", request.path},
                           {"status", static_cast<int>(response.status)},
                           {"request_id", request.id},
                           {"peer", request.peer}};
    if (response.uploaded_bytes) data["uploaded_bytes"] = *response.uploaded_bytes;
    try {
        services.catalog.transaction([&](soci::session& session) {
            storage::EventStore::append(session,
                                        {.topic = "audit",
                                         .subject = request.token.id,
                                         .type = "audit.write",
                                         .data = data});
        });
    } catch (const std::exception& error) {
        spdlog::error(
            nlohmann::json{{"event", "audit_not_written"}, {"what", error.what()}, {"data", data}}
                .dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
    }
}

}  // namespace divemesh::api
