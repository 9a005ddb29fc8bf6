#pragma once

#include "api/http.hpp"
#include "api/services.hpp"

// The web page. Public: it holds no data; what it shows it asks the API for.
namespace divemesh::api {

// Sends index.html, or, from a server that was built without the page, a line that says so.
Awaitable<Response> show_page(Request request, Services services);
// The same, for frames of the pages that --frame-ancestors names.
Awaitable<Response> show_page_in_frame(Request request, Services services);
// The same; a page for sharing links alone if this server is reached under a prefix or was built
// without the web page.
Awaitable<Response> show_share(Request request, Services services);
Awaitable<Response> get_plain_share_script(Request request, Services services);
// Sends a file that index.html refers to. Its name contains its hash, so browsers keep it.
Awaitable<Response> get_page_asset(Request request, Services services);

}  // namespace divemesh::api
