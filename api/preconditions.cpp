#include "api/preconditions.hpp"

#include <nlohmann/json.hpp>

#include "api/audit.hpp"
#include "api/etag.hpp"

namespace divemesh::api {

storage::Catalog audited_if_match(const Services& services,
                                  const Request& request,
                                  std::function<nlohmann::json()> shown) {
    if (!request.has_header("if-match")) return audited(services, request);
    return audited(services, request)
        .with_check([tags = request.header("if-match"), shown = std::move(shown)] {
            require_listed(tags, etag_of(json_text(shown())));
        });
}

void require_no_tag(const Request& request) {
    if (request.has_header("if-match")) require_listed(request.header("if-match"), "");
}

}  // namespace divemesh::api
