#pragma once

#include <string_view>

#include "api/http.hpp"
#include "api/services.hpp"

namespace divemesh::api {

// Returns whether an Accept-Encoding takes gzip (RFC 9110, 12.5.3).
bool accepts_gzip(std::string_view accept_encoding);

// Compresses JSON, text and meshes for a client that takes gzip, and says that the answer depends
// on that. Leaves alone what is short, a range of a file, compressed already or has a secret, whose
// length must not tell anything (BREACH). The tag of a compressed answer ends in "-gzip".
Awaitable<Response> with_content_coding(Request request, Services services, Response response);

}  // namespace divemesh::api
