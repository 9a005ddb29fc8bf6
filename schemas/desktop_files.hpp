#pragma once

#include <string_view>

namespace divemesh {

// Returns whether a file is one that the windows of macOS and Windows leave in folders that
// somebody looks at: .DS_Store, ._NAME, Thumbs.db, desktop.ini. It is no part of a dive.
bool is_left_by_desktop(std::string_view path);

}  // namespace divemesh
