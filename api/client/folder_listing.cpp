#include "api/client/folder_listing.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "schemas/desktop_files.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

namespace fs = std::filesystem;

// What a server accepts of a dive, which links to folders that hold links can exceed.
constexpr std::size_t kMaxFolders = 16;
constexpr std::size_t kMaxLinkedEntries = 2'000'000;
constexpr std::string_view kVersionControl = ".git";

FolderListing list_plain(const fs::path& folder) {
    FolderListing listing;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const auto type = entry.symlink_status().type();
        if (type == fs::file_type::directory ||
            is_left_by_desktop(entry.path().filename().string()))
            continue;
        auto& names = type == fs::file_type::regular ? listing.files : listing.left_out;
        names.push_back(entry.path().lexically_relative(folder).generic_string());
    }
    return listing;
}

// Lists a folder with what its links lead to.
class LinkFollower {
public:
    FolderListing run(const fs::path& folder) {
        list(folder, "");
        return std::move(listing_);
    }

private:
    void list(const fs::path& folder, const std::string& prefix) {
        entered_.push_back(fs::canonical(folder));
        for (const auto& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            if (name != kVersionControl && !is_left_by_desktop(name))
                add(entry.path(), prefix + name);
        }
        entered_.pop_back();
    }

    void add(const fs::path& path, const std::string& name) {
        if (++num_entries_ > kMaxLinkedEntries)
            throw Error(ErrorCode::TooLarge,
                        "with what its links lead to, the folder has more than " +
                            std::to_string(kMaxLinkedEntries) +
                            " files: remove the links that do not belong to the dive");
        std::error_code failure;
        const auto type = fs::status(path, failure).type();
        if (type == fs::file_type::regular)
            listing_.files.push_back(name);
        else if (type == fs::file_type::directory && can_enter(path))
            list(path, name + "/");
        else
            listing_.left_out.push_back(name);
    }

    bool can_enter(const fs::path& folder) const {
        if (entered_.size() > kMaxFolders) return false;
        return std::find(entered_.begin(), entered_.end(), fs::canonical(folder)) == entered_.end();
    }

    std::size_t num_entries_ = 0;
    std::vector<fs::path> entered_;  // from the root to the folder that is listed, without links
    FolderListing listing_;
};

}  // namespace

FolderListing list_folder(const fs::path& folder, Links links) {
    FolderListing listing =
        links == Links::Follow ? LinkFollower().run(folder) : list_plain(folder);
    std::sort(listing.files.begin(), listing.files.end());
    std::sort(listing.left_out.begin(), listing.left_out.end());
    return listing;
}

}  // namespace divemesh::api::client
