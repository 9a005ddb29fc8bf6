#include "worker/recording/unpack.hpp"

#include <algorithm>
#include <bzlib.h>
#include <limits>
#include <lz4frame.h>
#include <memory>
#include <new>
#include <zstd.h>

namespace divemesh::recording {
namespace {

constexpr std::size_t kFirstStep_bytes = std::size_t{1} << 20U;

// The limits of archives of dives.
constexpr std::int64_t kMaxUnpacked_bytes = std::int64_t{512} << 30U;
constexpr std::int64_t kMaxUnpackedRatio = 100;
constexpr std::int64_t kRatioCheckedFrom_bytes = std::int64_t{64} << 20U;

// Takes decompressed bytes. Its buffer doubles, up to one byte more than was stated: that byte
// shows data that are longer than they say.
class UnpackBuffer {
public:
    explicit UnpackBuffer(std::size_t stated_bytes) : stated_bytes_(stated_bytes) {}

    bool is_full() const { return used_ > stated_bytes_; }
    // Makes room if there is none left.
    void grow() {
        if (used_ == bytes_.size())
            bytes_.resize(std::min(stated_bytes_ + 1, used_ + std::max(used_, kFirstStep_bytes)));
    }
    char* free() { return bytes_.data() + used_; }
    std::size_t free_bytes() const { return bytes_.size() - used_; }
    void add(std::size_t num_bytes) { used_ += num_bytes; }
    Unpacked result() && {
        bytes_.resize(std::min(used_, stated_bytes_));
        return {std::move(bytes_), used_ == stated_bytes_};
    }

private:
    std::size_t stated_bytes_;
    std::size_t used_ = 0;
    std::string bytes_;
};

void unpack_lz4(std::string_view packed, UnpackBuffer& buffer) {
    LZ4F_dctx* created = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&created, LZ4F_VERSION)))
        throw std::bad_alloc();
    const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
        created, &LZ4F_freeDecompressionContext);
    while (!buffer.is_full()) {
        buffer.grow();
        std::size_t out = buffer.free_bytes();
        std::size_t in = packed.size();
        const std::size_t hint =
            LZ4F_decompress(context.get(), buffer.free(), &out, packed.data(), &in, nullptr);
        if (LZ4F_isError(hint)) return;
        buffer.add(out);
        packed.remove_prefix(in);
        if (out == 0 && in == 0) return;
        if (hint == 0 && packed.empty()) return;
    }
}

void unpack_zstd(std::string_view packed, UnpackBuffer& buffer) {
    const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                       &ZSTD_freeDCtx);
    if (!context) throw std::bad_alloc();
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    while (!buffer.is_full()) {
        buffer.grow();
        ZSTD_outBuffer out{buffer.free(), buffer.free_bytes(), 0};
        const std::size_t taken = in.pos;
        const std::size_t hint = ZSTD_decompressStream(context.get(), &out, &in);
        if (ZSTD_isError(hint)) return;
        buffer.add(out.pos);
        if (out.pos == 0 && in.pos == taken) return;
        if (hint == 0 && in.pos == in.size) return;
    }
}

void unpack_bzip2(std::string_view packed, UnpackBuffer& buffer) {
    bz_stream stream{};
    if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) throw std::bad_alloc();
    const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> ends(&stream,
                                                                          &BZ2_bzDecompressEnd);
    constexpr std::size_t kMost = std::numeric_limits<unsigned int>::max();
    stream.next_in = const_cast<char*>(packed.data());  // it is only read
    stream.avail_in = static_cast<unsigned int>(std::min(packed.size(), kMost));
    while (!buffer.is_full()) {
        buffer.grow();
        const auto room = static_cast<unsigned int>(std::min(buffer.free_bytes(), kMost));
        stream.next_out = buffer.free();
        stream.avail_out = room;
        const unsigned int waiting = stream.avail_in;
        const int state = BZ2_bzDecompress(&stream);
        buffer.add(room - stream.avail_out);
        if (state != BZ_OK || (stream.avail_out == room && stream.avail_in == waiting)) return;
    }
}

}  // namespace

std::optional<Codec> codec_from_text(std::string_view name) {
    if (name.empty() || name == "none") return Codec::None;
    if (name == "lz4") return Codec::Lz4;
    if (name == "zstd") return Codec::Zstd;
    if (name == "bz2") return Codec::Bzip2;
    return std::nullopt;
}

Unpacked unpack(Codec codec, std::string_view packed, std::size_t stated_bytes) {
    if (codec == Codec::None)
        return {std::string(packed.substr(0, stated_bytes)), packed.size() == stated_bytes};
    UnpackBuffer buffer(stated_bytes);
    if (codec == Codec::Lz4) unpack_lz4(packed, buffer);
    if (codec == Codec::Zstd) unpack_zstd(packed, buffer);
    if (codec == Codec::Bzip2) unpack_bzip2(packed, buffer);
    return std::move(buffer).result();
}

std::optional<std::uint64_t> stated_zstd_bytes(std::string_view packed) {
    const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
    return size;
}

bool is_bomb(std::int64_t unpacked_bytes, std::int64_t packed_bytes) {
    if (unpacked_bytes > kMaxUnpacked_bytes) return true;
    return unpacked_bytes > kRatioCheckedFrom_bytes &&
           unpacked_bytes / kMaxUnpackedRatio > packed_bytes;
}

}  // namespace divemesh::recording
