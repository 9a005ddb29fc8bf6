#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "worker/base/atomic_file.hpp"
#include "worker/io/laz_chunk.hpp"

namespace divemesh::io {

// Returns the content of the variable length record that a LAZ file has beside those of LAS, user
// "laszip encoded", number 22204: which compressor, how large its chunks are, and its items.
std::string laszip_record();

// Writes the points of a LAZ file: the offset of the chunk table, chunks of 50,000 points and the
// table. It holds one chunk in memory. Throws as AtomicFile does.
class LazPoints {
public:
    // The points follow the first `offset_bytes` of the file, which the caller has written.
    LazPoints(base::AtomicFile& file, std::uint64_t offset_bytes);

    void add(const LasPoint& point);
    void finish();

private:
    void write_chunk();

    base::AtomicFile& file_;
    std::uint64_t offset_bytes_;
    LazChunk chunk_;
    std::vector<std::uint32_t> chunk_sizes_bytes_;
};

}  // namespace divemesh::io
