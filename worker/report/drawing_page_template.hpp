#pragma once

#include <string_view>

namespace divemesh::report {

// Returns the template beside this file, for fill_template(): `data` is JSON that is safe in a
// script.
std::string_view drawing_page_template_html();

}  // namespace divemesh::report
