#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "schemas/links.hpp"

namespace divemesh::api::client {

// The names below a folder, separated by '/', sorted by bytes.
struct FolderListing {
    std::vector<std::string> files;
    std::vector<std::string> left_out;  // neither files nor folders
};

// Lists the regular files below a folder. With Links::Follow those that links lead to are among
// them under the names of the links; links that lead nowhere or to a folder that they lie in are
// left out, and so is what Git keeps (.git), as the links of git-annex lead into it. What desktops
// leave (is_left_by_desktop()) is in neither list. Throws Error{TooLarge} if links make more of the
// folder than a server accepts.
FolderListing list_folder(const std::filesystem::path& folder, Links links);

}  // namespace divemesh::api::client
