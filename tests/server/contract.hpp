#pragma once

#include <string>

#include "tests/server/raw_client.hpp"

namespace divemesh {

// What api/openapi.yaml does not allow about an answer; "" when it is as documented. An answer
// below 400 needs an entry of its own: its status, its content type, its body by the schema, its
// required headers. A failure may be any that HTTP knows, told as a Problem. What is asked of no
// operation's address is a failure too.
std::string contract_breach(const std::string& method,
                            const std::string& target,
                            const RawResponse& response);

}  // namespace divemesh
