#pragma once

#include <string>

#include "tests/server/raw_client.hpp"

namespace divemesh {

// Returns how a response differs from api/openapi.yaml; "" if it is as documented. A response below
// 400 needs an entry for its status, with its content type, the schema of its body and its required
// headers. Any other response may have any status from 400 on, with the body of a Problem. A
// request that no operation documents has to fail.
std::string contract_breach(const std::string& method,
                            const std::string& target,
                            const RawResponse& response);

}  // namespace divemesh
