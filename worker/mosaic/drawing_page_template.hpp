#pragma once

#include <string_view>

namespace divemesh::worker {

// drawing_page_template.html, with {{data}} where its data go.
std::string_view drawing_page_template_html();

}  // namespace divemesh::worker
