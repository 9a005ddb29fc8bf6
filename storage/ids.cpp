#include "storage/ids.hpp"

#include <sys/random.h>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::storage {
namespace {

std::vector<unsigned char> random_bytes(std::size_t num_bytes) {
    std::vector<unsigned char> bytes(num_bytes);
    // Up to 256 bytes come whole or not at all.
    if (getrandom(bytes.data(), num_bytes, 0) != static_cast<ssize_t>(num_bytes))
        throw Error(ErrorCode::Unavailable, "the system gives no random bytes");
    return bytes;
}

}  // namespace

std::string new_id(std::string_view kind) {
    static constexpr std::string_view kDigits = "abcdefghijklmnopqrstuvwxyz234567";
    std::string id = std::string(kind) + "_";
    for (const unsigned char byte : random_bytes(20)) id += kDigits[byte % kDigits.size()];
    return id;
}

std::string random_hex(std::size_t num_bytes) {
    static constexpr std::string_view kDigits = "0123456789abcdef";
    std::string hex;
    for (const unsigned char byte : random_bytes(num_bytes)) {
        hex += kDigits[byte >> 4];
        hex += kDigits[byte & 15];
    }
    return hex;
}

}  // namespace divemesh::storage
