#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::pipeline {

// A store of the stages' results beyond the attempt that made them, so that a retry or a run with
// other options can start later. An entry is the files of a stage, under a key of everything that
// they were made from. It is stored completely or not at all.
class StageStore {
public:
    virtual ~StageStore() = default;

    // Puts the entry's files into the folder `into`, under their names in `from`. They may share
    // their bytes with the store and must not be changed in place. Returns false, and leaves none
    // of them in `into`, if the entry does not exist or is damaged.
    virtual bool fetch(const std::string& key, const std::filesystem::path& into) = 0;

    // Stores `names`, files or folders in `from`, which must not be changed in place afterwards. An
    // existing entry stays. Never throws: what cannot be stored is made again.
    virtual void store(const std::string& key,
                       const std::filesystem::path& from,
                       const std::vector<std::string>& names) = 0;

    // Removes the entry if it exists.
    virtual void drop(const std::string& key) = 0;
};

}  // namespace divemesh::pipeline
