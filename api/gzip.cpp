#include "api/gzip.hpp"

#include <algorithm>
#include <span>
#include <zlib.h>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr int kGzipWindow = 15 + 16;  // 16: in the gzip format
constexpr int kFewBytesLevel = 6;
constexpr int kFileLevel = 1;
constexpr std::size_t kReadBytes = std::size_t{64} << 10;

class Deflater {
public:
    explicit Deflater(int level) {
        if (deflateInit2(&stream_, level, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY) != Z_OK)
            throw std::bad_alloc();
    }
    ~Deflater() { deflateEnd(&stream_); }
    Deflater(const Deflater&) = delete;
    Deflater& operator=(const Deflater&) = delete;

    // `bytes` must live until it is used up.
    void put(std::span<const char> bytes) {
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): zlib does not write to it
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
        stream_.avail_in = static_cast<uInt>(bytes.size());
    }
    bool is_used_up() const { return stream_.avail_in == 0; }
    bool is_finished() const { return finished_; }

    // Returns how many bytes it wrote. `last`: what was put is the end of the input.
    std::size_t take(std::span<char> into, bool last) {
        stream_.next_out = reinterpret_cast<Bytef*>(into.data());
        stream_.avail_out = static_cast<uInt>(into.size());
        const int result = deflate(&stream_, last ? Z_FINISH : Z_NO_FLUSH);
        finished_ = result == Z_STREAM_END;
        return into.size() - stream_.avail_out;
    }

private:
    z_stream stream_{};
    bool finished_ = false;
};

class GzipSource : public BodySource {
public:
    explicit GzipSource(FilePart file) : file_(std::move(file)), buffer_(kReadBytes) {}

    std::size_t read(std::span<char> bytes) override {
        std::size_t size = 0;
        while (size == 0 && !deflater_.is_finished()) {
            if (deflater_.is_used_up() && file_.length > 0) put_more();
            size = deflater_.take(bytes, file_.length == 0);
        }
        return size;
    }

private:
    void put_more() {
        const auto wanted = std::min<std::int64_t>(kReadBytes, file_.length);
        const std::span<char> part(buffer_.data(), static_cast<std::size_t>(wanted));
        const std::size_t size = file_.reader->read_at(file_.offset, part);
        if (size == 0) throw Error(ErrorCode::BadData, "the file ends too early");
        file_.offset += static_cast<std::int64_t>(size);
        file_.length -= static_cast<std::int64_t>(size);
        deflater_.put(part.first(size));
    }

    FilePart file_;
    std::vector<char> buffer_;
    Deflater deflater_{kFileLevel};
};

}  // namespace

std::string gzip(std::string_view bytes) {
    Deflater deflater(kFewBytesLevel);
    deflater.put(bytes);
    std::string packed(bytes.size() / 4 + 256, '\0');
    std::size_t size = 0;
    while (!deflater.is_finished()) {
        if (size == packed.size()) packed.resize(2 * size);
        size += deflater.take(std::span(packed).subspan(size), true);
    }
    packed.resize(size);
    return packed;
}

std::unique_ptr<BodySource> gzip_source(FilePart file) {
    return std::make_unique<GzipSource>(std::move(file));
}

}  // namespace divemesh::api
