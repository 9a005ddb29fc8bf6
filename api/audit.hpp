#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// The catalog for a change in the name of who asks: who it was, from where and what they asked for
// is written in the transaction of the change, as an event of the topic audit, which administrators
// alone see. The change has to be one transaction, or there are as many events.
// `uploaded_bytes`: of an upload that this request made whole.
storage::Catalog audited(const Services& services,
                         const Request& request,
                         std::optional<std::int64_t> uploaded_bytes = std::nullopt);

// The same for a change that no request asks for: `who` ("serve --import") does `what`.
storage::Catalog audited(const storage::Catalog& catalog,
                         const std::string& who,
                         const std::string& what);

// The same inside a transaction that is under way.
void note_audit(soci::session& session, const std::string& who, const std::string& what);

// For an upload that this request made whole and that became no dive by it: its bytes came in many
// transactions, so the event follows them. Blocks: for the pool. What cannot be written is logged.
void audit_uploaded(const Services& services, const Request& request, std::int64_t num_bytes);

}  // namespace divemesh::api
