#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/content_hash.hpp"
#include "worker/dive/dive_source.hpp"

namespace divemesh::dive {

// The files of a source by their names in the dive: "mav0/cam0/data.csv", "dive.json".
class DiveFiles {
public:
    // Throws Error{BadData} if the files contain no dive.
    explicit DiveFiles(std::unique_ptr<DiveSource> source);

    bool has(std::string_view path) const { return find(path) != nullptr; }
    std::int64_t size_bytes(std::string_view path) const;
    // Returns the contents of a file; nullopt if it does not exist or is larger than `max_bytes`.
    // Thread-safe.
    std::optional<std::string> read(std::string_view path, std::int64_t max_bytes) const;
    // Returns the names directly under "mav0/", sorted.
    std::vector<std::string> sensors() const;
    // Returns the names of the files directly in a folder ("mav0/cam0/data/"), sorted.
    std::vector<std::string> names_in(std::string_view folder) const;
    // Returns the folders beside or below the dive that hold another one, sorted.
    const std::vector<std::string>& other_dives() const { return other_dives_; }
    // Returns the hashes of the dive. Reads every file that is not hashed yet.
    ContentHash content_hash(const base::ProgressCallback& progress) const;

private:
    struct Entry {
        std::string path;
        const SourceFile* file = nullptr;
    };
    const SourceFile* find(std::string_view path) const;

    std::unique_ptr<DiveSource> source_;
    std::vector<Entry> entries_;          // sorted by path
    std::vector<Entry> left_by_desktop_;  // no part of the dive
    std::vector<std::string> other_dives_;
};

}  // namespace divemesh::dive
