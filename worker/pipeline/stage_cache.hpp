#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "worker/pipeline/stage_store.hpp"

namespace divemesh::pipeline {

// The stage store as a folder on this machine. An entry is a folder with the stage's files and a
// list of their sizes and hashes; it is written under a temporary name, synced and renamed. Files
// are hard-linked in and out if the file system allows. Several processes may use one folder. An
// entry that does not match its list is removed and counts as missing. Above `max_bytes` the least
// recently used entries are removed, and others may remove entries at any time for space on the
// disk (base/cache_folder.hpp): what was fetched stays.
class StageCache final : public StageStore {
public:
    StageCache() = default;  // a store that stays empty
    // Stays empty if `folder` is empty or cannot be created, or `max_bytes` is 0.
    StageCache(std::filesystem::path folder, std::int64_t max_bytes);

    bool fetch(const std::string& key, const std::filesystem::path& into) override;
    void store(const std::string& key,
               const std::filesystem::path& from,
               const std::vector<std::string>& names) override;
    void drop(const std::string& key) override;

private:
    bool is_open() const { return !folder_.empty(); }
    void write(const std::string& key,
               const std::filesystem::path& from,
               const std::vector<std::string>& names) const;

    std::filesystem::path folder_;
    std::int64_t max_bytes_ = 0;
};

}  // namespace divemesh::pipeline
