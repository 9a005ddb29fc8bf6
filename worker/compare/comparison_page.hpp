#pragma once

#include <string_view>

namespace divemesh::compare {

// Returns the template beside this file, for fill_template().
std::string_view comparison_page_html();

}  // namespace divemesh::compare
