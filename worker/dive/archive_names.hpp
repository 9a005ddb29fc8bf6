#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include "worker/dive/dive.hpp"

namespace divemesh::dive {

// Passes the names of the entries of an archive to `look` until it returns false. What cannot be
// read, or exceeds the limits, ends it too: opening the archive says what is wrong.
void look_through_archive(const std::filesystem::path& archive,
                          const DiveLimits& limits,
                          const std::function<bool(std::string_view name)>& look);

}  // namespace divemesh::dive
