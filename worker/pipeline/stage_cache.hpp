#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "worker/pipeline/stage_store.hpp"

namespace divemesh::pipeline {

// The store of stages as a folder on this machine. An entry is a folder with the stage's files and
// a list of their sizes and hashes; it is written beside, synced and renamed. Files are linked in
// and out where the file system allows. Any number of processes may use one folder. An entry that
// does not fit its list is removed and counts as missing. When there are more than `max_bytes`, the
// entries that were not used for longest go.
class StageCache final : public StageStore {
public:
    StageCache() = default;  // keeps nothing
    // Keeps nothing when `folder` is empty or cannot be made, or `max_bytes` is 0.
    StageCache(std::filesystem::path folder, std::int64_t max_bytes);

    bool fetch(const std::string& key, const std::filesystem::path& into) override;
    void store(const std::string& key,
               const std::filesystem::path& from,
               const std::vector<std::string>& names) override;
    void drop(const std::string& key) override;

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

}  // namespace divemesh::pipeline
