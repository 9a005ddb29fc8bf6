#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "storage/blob_store.hpp"
#include "worker/pipeline/stage_store.hpp"

namespace divemesh::pipeline {

// A store of stages that keeps only blobs, for tests: one blob for each file, and a list with their
// hashes, written last. It makes no links and has no folder.
class BlobStageStore final : public StageStore {
public:
    explicit BlobStageStore(storage::BlobStore& blobs) : blobs_(blobs) {}

    bool fetch(const std::string& key, const std::filesystem::path& into) override;
    void store(const std::string& key,
               const std::filesystem::path& from,
               const std::vector<std::string>& names) override;
    void drop(const std::string& key) override;

    static std::string blob_of(const std::string& key, const std::string& file);

private:
    std::string read(const std::string& blob) const;

    storage::BlobStore& blobs_;
};

}  // namespace divemesh::pipeline
