#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::pipeline {

// Keeps what stages made beyond the attempt that made it, so that a retry or a run with other
// options starts where it can. An entry is the files that a stage left, under a key that stands for
// all that they were made from; it is there whole or not at all.
class StageStore {
public:
    virtual ~StageStore() = default;

    // Puts the files of the entry into the folder `into`, under the names that they had in `from`.
    // They may share their bytes with the store, so they must not be changed in place. Returns
    // false, and leaves none of them in `into`, when there is no such entry or it is damaged.
    virtual bool fetch(const std::string& key, const std::filesystem::path& into) = 0;

    // Keeps `names`, files or folders in `from`, which must not be changed in place after that. An
    // entry that is there already stays. Never throws: what cannot be kept is made again.
    virtual void store(const std::string& key,
                       const std::filesystem::path& from,
                       const std::vector<std::string>& names) = 0;

    // Removes the entry, if there is one.
    virtual void drop(const std::string& key) = 0;
};

}  // namespace divemesh::pipeline
