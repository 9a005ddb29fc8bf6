#pragma once

#include <string_view>

namespace divemesh::report {

// Return the templates beside this file, for fill_template().
std::string_view accuracy_page_html();
std::string_view accuracy_rows_html();
std::string_view dive_rows_html();
std::string_view findings_html();
std::string_view grid_html();
std::string_view page_head_html();
std::string_view plot_svg();
std::string_view reconstruction_page_html();
std::string_view rows_html();

}  // namespace divemesh::report
