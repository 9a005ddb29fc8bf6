#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::worker {

// What stages made, kept beyond the attempt by content key, so that a retry or a run with other
// options starts where it can. An entry is a folder with the stage's files and a list of their
// sizes and hashes; it is written beside, synced and renamed. Any number of processes may use one
// cache folder. What does not fit its list is removed and counts as missing. When there are more
// than `max_bytes`, the entries that were not used for longest go.
class StageCache {
public:
    StageCache() = default;  // keeps nothing
    StageCache(std::filesystem::path folder, std::int64_t max_bytes);

    // Puts the files of the entry into the folder `into`, as links where the file system allows:
    // they must not be changed in place. False: there is no such entry, or it is damaged.
    bool fetch(const std::string& key, const std::filesystem::path& into) const;

    // Keeps `names`, files or folders in `from`. Never throws: what cannot be kept is made again.
    void store(const std::string& key,
               const std::filesystem::path& from,
               const std::vector<std::string>& names) const;

    void drop(const std::string& key) const;

private:
    struct Entry;

    bool is_open() const { return !folder_.empty(); }
    void write(const std::string& key,
               const std::filesystem::path& from,
               const std::vector<std::string>& names) const;
    void remove(const std::filesystem::path& entry) const;
    void evict() const;

    std::filesystem::path folder_;
    std::int64_t max_bytes_ = 0;
};

// `to` is what `from` is, its folder made when missing; neither may be changed in place after that.
void link_or_copy(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace divemesh::worker
