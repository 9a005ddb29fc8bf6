#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Returns a catalog for a change that `request` asks for. Each transaction of it also writes an
// event of the topic audit: the caller, its address and the request. Only administrators see these
// events. A change must be one transaction, or it writes several events. `uploaded_bytes`: the size
// of an upload that this request completed.
storage::Catalog audited(const Services& services,
                         const Request& request,
                         std::optional<std::int64_t> uploaded_bytes = std::nullopt);

// Returns the same for a change that no request asks for, e.g. `who` "serve --import" does `what`.
storage::Catalog audited(const storage::Catalog& catalog,
                         const std::string& who,
                         const std::string& what);

// Writes an audit event when an address begins to use the sharing link of the request: one for all
// it reads within ten minutes. Logs an event that cannot be written. Does nothing for other tokens.
Awaitable<void> audit_visit(Request request, Services services);

// Writes the audit event inside a transaction that is under way.
void append_audit_event(soci::session& session, const std::string& who, const std::string& what);

// Writes the audit event of an upload that this request completed but that did not become a dive.
// Its bytes were stored in many transactions, so the event follows them. Blocks: run it in the
// pool. Logs an event that cannot be written.
void audit_uploaded(const Services& services, const Request& request, std::int64_t num_bytes);

}  // namespace divemesh::api
