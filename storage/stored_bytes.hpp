#pragma once

#include <soci/blob.h>
#include <soci/soci.h>
#include <string>

#include "storage/dialect.hpp"
#include "storage/session.hpp"

// Writes and reads columns of bytes, which every database takes in a way of its own.
namespace divemesh::storage {

std::string to_hex(const std::string& bytes);

// Calls write(place, use): `place` stands for the value in the statement, `use` binds it under
// `name`. Returns what `write` returns.
template <typename Write>
auto with_bytes(soci::session& session,
                const std::string& name,
                const std::string& bytes,
                const Write& write) {
    if (!dialect_of(session).bytes_are_blobs) {
        const std::string hex = to_hex(bytes);
        return write("decode(:" + name + ", 'hex')", soci::use(hex, name));
    }
    soci::blob blob(session);
    blob.write(0, bytes.data(), bytes.size());
    return write(":" + name, soci::use(blob, name));
}

// Returns the bytes in this column of the row with this number; "" if there is no such row.
std::string read_bytes(soci::session& session,
                       const std::string& table,
                       const std::string& column,
                       std::int64_t number);

}  // namespace divemesh::storage
