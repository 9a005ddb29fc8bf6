#pragma once

#include <string_view>

// The page of a sharing link where the web page is not: behind a proxy that adds a prefix, and in a
// program that was built without it.
namespace divemesh::api {

std::string_view plain_share_html();
std::string_view plain_share_js();

}  // namespace divemesh::api
