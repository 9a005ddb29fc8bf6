#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace divemesh::recording {

// How the bytes of a chunk are compressed: LZ4 and Zstandard as frames, bzip2 as a stream.
enum class Codec { None, Lz4, Zstd, Bzip2 };

// Returns the codec of a name in a recording ("" and "none": no compression); nullopt for others.
std::optional<Codec> codec_from_text(std::string_view name);

// Decompressed bytes: the beginning only, where the compressed bytes are damaged or cut.
struct Unpacked {
    std::string bytes;
    bool is_whole = false;  // the stated size was met exactly
};

// Decompresses bytes up to the size that the recording states. Memory grows with what comes out, so
// a false size costs none.
Unpacked unpack(Codec codec, std::string_view packed, std::size_t stated_bytes);

}  // namespace divemesh::recording
