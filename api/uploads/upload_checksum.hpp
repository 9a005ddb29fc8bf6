#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace divemesh::api {

// The algorithms that Tus-Checksum-Algorithm names.
constexpr std::string_view kChecksumAlgorithms = "sha1,sha256,crc32c";

// Checks Upload-Checksum of tus 1.0, "sha1 <base64>", against the bytes of one request as they
// arrive. crc32c is CRC-32C (RFC 3720, appendix B.4), four bytes, big-endian.
class UploadChecksum {
public:
    // Throws Error{InvalidArgument} for another algorithm, invalid base64 and a digest of the wrong
    // length.
    explicit UploadChecksum(std::string_view header);
    ~UploadChecksum();
    UploadChecksum(UploadChecksum&&) noexcept;

    void update(std::span<const char> bytes);
    bool matches();  // compares all bytes so far; ask it once

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace divemesh::api
