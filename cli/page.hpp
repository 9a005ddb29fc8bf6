#pragma once

#include <span>

#include "api/page_file.hpp"

namespace divemesh::cli {

// Returns the files of the web page, compiled in; empty without it (DIVEMESH_PAGE).
std::span<const api::PageFile> page();

}  // namespace divemesh::cli
