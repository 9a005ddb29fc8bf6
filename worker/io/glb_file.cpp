#include "worker/io/glb_file.hpp"

#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::io {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kCopied_bytes = std::size_t{1} << 20;

std::string little_endian(std::uint64_t value) {
    const auto word = static_cast<std::uint32_t>(value);
    std::string bytes(sizeof word, '\0');
    std::memcpy(bytes.data(), &word, sizeof word);
    return bytes;
}

void copy(const std::filesystem::path& from, std::uint64_t size_bytes, base::AtomicFile& output) {
    std::ifstream stream(from, std::ios::binary);
    std::vector<char> bytes(kCopied_bytes);
    while (size_bytes > 0) {
        const auto num = std::min<std::uint64_t>(size_bytes, bytes.size());
        if (!stream.read(bytes.data(), static_cast<std::streamsize>(num)))
            throw Error(ErrorCode::Unavailable, "cannot read " + from.string() + " again");
        output.write({bytes.data(), static_cast<std::size_t>(num)});
        size_bytes -= num;
    }
}

}  // namespace

GlbFile::GlbFile(const std::filesystem::path& file)
    : file_(file),
      buffer_file_(file.string() + ".buffer"),
      buffer_(buffer_file_, base::Durability::Unsynced) {}

GlbFile::~GlbFile() {
    std::error_code ignored;
    std::filesystem::remove(buffer_file_, ignored);
}

void GlbFile::check_size(std::uint64_t size_bytes) const {
    if (size_bytes > std::numeric_limits<std::uint32_t>::max())
        throw Error(
            ErrorCode::TooLarge,
            file_.string() + " would exceed the 4 GiB limit of glTF binary: choose a larger voxel");
}

std::uint64_t GlbFile::add(std::string_view bytes) {
    const std::uint64_t begin = size_bytes_;
    const std::uint64_t padding = (4 - bytes.size() % 4) % 4;
    check_size(begin + bytes.size() + padding);
    buffer_.write(bytes);
    buffer_.write(std::string(padding, '\0'));
    size_bytes_ += bytes.size() + padding;
    return begin;
}

void GlbFile::commit(const nlohmann::json& document) {
    buffer_.commit();
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::uint64_t total = 12 + 8 + text.size() + (size_bytes_ > 0 ? 8 + size_bytes_ : 0);
    check_size(total);
    base::AtomicFile output(file_);
    output.write("glTF" + little_endian(2) + little_endian(total));
    output.write(little_endian(text.size()) + "JSON" + text);
    if (size_bytes_ > 0) {
        output.write(little_endian(size_bytes_) + std::string("BIN\0", 4));
        copy(buffer_file_, size_bytes_, output);
    }
    output.commit();
}

}  // namespace divemesh::io
