#include "storage/blob_store.hpp"

#include "schemas/error.hpp"
#include "storage/directory_blob_store.hpp"
#include "storage/s3_blob_store.hpp"
#include "storage/s3_credentials.hpp"

namespace divemesh::storage {

std::unique_ptr<BlobStore> open_blob_store(const std::string& url,
                                           Opening opening,
                                           const std::filesystem::path& stage) {
    if (is_s3_url(url)) return open_s3_blob_store(parse_s3_url(url), find_s3_credentials(), stage);
    static const std::string kFile = "file://";
    if (url.starts_with(kFile)) return open_directory_blob_store(url.substr(kFile.size()), opening);
    if (!url.empty() && url.find("://") == std::string::npos)
        return open_directory_blob_store(url, opening);
    throw Error(
        ErrorCode::InvalidArgument,
        "cannot use the blob store '" + url + "': give a folder, file:///path or s3://bucket");
}

}  // namespace divemesh::storage
