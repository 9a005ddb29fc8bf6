#pragma once

namespace divemesh::storage {

// What the SQL of the stores cannot leave to the database: all else is written so that every engine
// takes it.
struct Dialect {
    // Returns the database's clock in unix milliseconds.
    const char* clock_query;
    // Whether a text may hold any bytes. If not, it must be UTF-8 without zeros.
    bool text_holds_any_bytes;
    // Whether a column of bytes is a soci::blob. If not, it is written and read as hexadecimal
    // text.
    bool bytes_are_blobs;
    // Whether a statement stays prepared on its connection, as to plan it takes longer than to run
    // it.
    bool keeps_statements;
};

}  // namespace divemesh::storage
