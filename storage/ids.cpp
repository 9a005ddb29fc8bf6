#include "storage/ids.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <sys/random.h>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::storage {
namespace {

std::vector<unsigned char> random_bytes(std::size_t num_bytes) {
    std::vector<unsigned char> bytes(num_bytes);
    // Requests of up to 256 bytes are never cut short.
    if (getrandom(bytes.data(), num_bytes, 0) != static_cast<ssize_t>(num_bytes))
        throw Error(ErrorCode::Unavailable, "the system provides no random bytes");
    return bytes;
}

// Returns the wall clock, but strictly increasing within this process.
std::int64_t next_microsecond() {
    static std::atomic<std::int64_t> last = 0;
    const std::int64_t now = std::chrono::duration_cast<std::chrono::microseconds>(
                                 std::chrono::system_clock::now().time_since_epoch())
                                 .count();
    std::int64_t before = last.load();
    while (!last.compare_exchange_weak(before, std::max(now, before + 1))) {
    }
    return std::max(now, before + 1);
}

}  // namespace

std::string new_id(std::string_view kind) {
    // In ASCII order, so that ids sort as the numbers do.
    static constexpr std::string_view kDigits = "0123456789abcdefghijklmnopqrstuv";
    std::string digits(20, '0');
    std::int64_t microseconds = next_microsecond();
    for (int i = 10; i >= 0; --i, microseconds >>= 5) digits[i] = kDigits[microseconds & 31];
    const std::vector<unsigned char> bytes = random_bytes(9);
    for (int i = 0; i < 9; ++i) digits[11 + i] = kDigits[bytes[i] & 31];
    return std::string(kind) + "_" + digits;
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
