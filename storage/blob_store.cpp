#include "storage/blob_store.hpp"

#include "schemas/error.hpp"
#include "storage/directory_blob_store.hpp"

namespace divemesh::storage {

std::unique_ptr<BlobStore> open_blob_store(const std::string& url, Opening opening) {
    static const std::string kFile = "file://";
    if (url.starts_with(kFile)) return open_directory_blob_store(url.substr(kFile.size()), opening);
    if (!url.empty() && url.find("://") == std::string::npos)
        return open_directory_blob_store(url, opening);
    throw Error(ErrorCode::InvalidArgument,
                "cannot use the blob store '" + url + "': give a folder or file:///path");
}

}  // namespace divemesh::storage
