#pragma once

#include <cstddef>
#include <cstdint>
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

// The first bytes of a frame of Zstandard.
inline constexpr std::string_view kZstdMagic = "\x28\xb5\x2f\xfd";

// Returns the size that the head of a frame of Zstandard states; nullopt if it states none.
std::optional<std::uint64_t> stated_zstd_bytes(std::string_view packed);

// Returns whether a recording unpacks to more than archives of dives may: 512 GiB, or 100 times its
// size where that is more than 64 MiB.
bool is_bomb(std::int64_t unpacked_bytes, std::int64_t packed_bytes);

}  // namespace divemesh::recording
