#include "schemas/token.hpp"

#include <algorithm>

namespace divemesh {

bool Token::allows(std::string_view scope) const {
    return !revoked && std::any_of(scopes.begin(), scopes.end(), [&](const std::string& held) {
        return held == scope || held == "admin";
    });
}

}  // namespace divemesh
