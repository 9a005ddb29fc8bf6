#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "schemas/file_descriptor.hpp"
#include "storage/blob_store.hpp"

namespace divemesh::storage {

// Uploads while they arrive, as files below a folder of the server's own disk. Keys and errors are
// those of BlobStore.
class UploadStage {
public:
    explicit UploadStage(FileDescriptor folder) : folder_(std::move(folder)) {}

    std::unique_ptr<StagedBlob> open(const std::string& key, std::int64_t num_durable_bytes) const;
    std::int64_t size_bytes(const std::string& key) const;  // 0: there is none
    std::unique_ptr<BlobReader> read(const std::string& key) const;
    void remove(const std::string& key) const;  // does nothing if there is none

    // Returns the open file, durable; one that is not open if there is none.
    FileDescriptor finished(const std::string& key) const;

    const FileDescriptor& folder() const { return folder_; }

private:
    FileDescriptor find(const std::string& key) const;

    FileDescriptor folder_;
};

}  // namespace divemesh::storage
