#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace divemesh::api {

// What Tus-Checksum-Algorithm names.
constexpr std::string_view kChecksumAlgorithms = "sha1,sha256,crc32c";

// Upload-Checksum of tus 1.0, "sha1 <base64>", against the bytes of one request as they come.
// crc32c is CRC-32C (RFC 3720, appendix B.4), four bytes, the most significant first.
class UploadChecksum {
public:
    // Throws Error{InvalidArgument} for another algorithm, what is not base64 and a digest of the
    // wrong length.
    explicit UploadChecksum(std::string_view header);
    ~UploadChecksum();
    UploadChecksum(UploadChecksum&&) noexcept;

    void update(std::span<const char> bytes);
    bool matches();  // everything so far; asked once

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace divemesh::api
