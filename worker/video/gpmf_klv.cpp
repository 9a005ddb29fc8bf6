#include "worker/video/gpmf_klv.hpp"

#include <algorithm>
#include <bit>

namespace divemesh::video {
namespace {

constexpr std::size_t kHead_bytes = 8;

// Returns a number of a type for which size_of_type() is not 0.
double number_of(char type, std::string_view bytes) {
    const std::uint64_t bits = big_endian(bytes);
    switch (type) {
        case 'b': return static_cast<std::int8_t>(bits);
        case 's': return static_cast<std::int16_t>(bits);
        case 'l': return static_cast<std::int32_t>(bits);
        case 'j': return static_cast<double>(static_cast<std::int64_t>(bits));
        case 'q': return static_cast<std::int32_t>(bits) / 65536.0;
        case 'Q': return static_cast<double>(static_cast<std::int64_t>(bits)) / 4294967296.0;
        case 'f': return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
        case 'd': return std::bit_cast<double>(bits);
        default: return static_cast<double>(bits);
    }
}

}  // namespace

std::optional<Klv> KlvList::next() {
    if (bytes_.size() < kHead_bytes) {
        is_damaged_ = is_damaged_ || !bytes_.empty();
        return std::nullopt;
    }
    Klv klv{bytes_.substr(0, 4),
            bytes_[4],
            static_cast<unsigned char>(bytes_[5]),
            big_endian(bytes_.substr(6, 2)),
            {}};
    const std::size_t size = klv.sample_bytes * klv.num_samples;  // below 2^24
    const std::size_t filled = (size + 3) / 4 * 4;
    if (klv.key == std::string_view("\0\0\0\0", 4)) return std::nullopt;  // filled up to the end
    if (size > bytes_.size() - kHead_bytes) {
        is_damaged_ = true;
        return std::nullopt;
    }
    klv.value = bytes_.substr(kHead_bytes, size);
    bytes_.remove_prefix(std::min(kHead_bytes + filled, bytes_.size()));
    return klv;
}

std::uint64_t big_endian(std::string_view bytes) {
    std::uint64_t value = 0;
    for (const char byte : bytes) value = value << 8U | static_cast<unsigned char>(byte);
    return value;
}

// clang-format off
std::size_t size_of_type(char type) {
    switch (type) {
        case 'b': case 'B': case 'c': return 1;
        case 's': case 'S': return 2;
        case 'l': case 'L': case 'f': case 'q': return 4;
        case 'd': case 'j': case 'J': case 'Q': return 8;
        default: return 0;
    }
}
// clang-format on

std::vector<double> numbers_of(const Klv& klv) {
    const std::size_t size = size_of_type(klv.type);
    std::vector<double> numbers;
    if (size == 0 || klv.sample_bytes % size != 0) return numbers;
    numbers.reserve(klv.value.size() / size);
    for (std::size_t at = 0; at + size <= klv.value.size(); at += size)
        numbers.push_back(number_of(klv.type, klv.value.substr(at, size)));
    return numbers;
}

std::vector<std::vector<double>> samples_of(const Klv& klv, std::string_view types) {
    std::size_t sample_bytes = 0;
    for (const char type : types) {
        if (size_of_type(type) == 0) return {};
        sample_bytes += size_of_type(type);
    }
    std::vector<std::vector<double>> samples;
    if (sample_bytes == 0 || sample_bytes != klv.sample_bytes) return samples;
    for (std::size_t begin = 0; begin + sample_bytes <= klv.value.size(); begin += sample_bytes) {
        std::size_t at = begin;
        samples.emplace_back();
        for (const char type : types) {
            samples.back().push_back(number_of(type, klv.value.substr(at, size_of_type(type))));
            at += size_of_type(type);
        }
    }
    return samples;
}

}  // namespace divemesh::video
