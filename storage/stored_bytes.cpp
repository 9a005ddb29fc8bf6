#include "storage/stored_bytes.hpp"

#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

int digit_of(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

std::string from_hex(const std::string& hex) {
    std::string bytes;
    bytes.reserve(hex.size() / 2);
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes += static_cast<char>(digit_of(hex[i]) << 4 | digit_of(hex[i + 1]));
    return bytes;
}

}  // namespace

std::string to_hex(const std::string& bytes) {
    static constexpr std::string_view kDigits = "0123456789abcdef";
    std::string hex;
    hex.reserve(2 * bytes.size());
    for (const char c : bytes) {
        const auto byte = static_cast<unsigned char>(c);
        hex += kDigits[byte >> 4];
        hex += kDigits[byte & 15];
    }
    return hex;
}

std::string read_bytes(soci::session& session,
                       const std::string& table,
                       const std::string& column,
                       std::int64_t number) {
    const std::string from = " FROM " + table + " WHERE number = :number";
    if (!dialect_of(session).bytes_are_blobs)
        return from_hex(select_one<TextRow>(session,
                                            "SELECT encode(" + column + ", 'hex')" + from,
                                            soci::use(number, "number"))
                            .value_or(""));
    fault_point();
    soci::blob blob(session);  // its statement ends first, because it lives as long as its session
    session << "SELECT " + column + from, soci::into(blob), soci::use(number, "number");
    std::string bytes(blob.get_len(), '\0');
    blob.read(0, bytes.data(), bytes.size());
    return bytes;
}

}  // namespace divemesh::storage
