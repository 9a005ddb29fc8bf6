#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

static_assert(std::endian::native == std::endian::little);

// One record of a binary file, little-endian and without padding, value by value.
class Record {
public:
    template <typename Value>
    void put(const Value& value) {
        static_assert(std::is_arithmetic_v<Value>);
        char bytes[sizeof value];
        std::memcpy(bytes, &value, sizeof value);
        bytes_.append(bytes, sizeof value);
    }
    template <typename Value>
    void put(const Eigen::Matrix<Value, 3, 1>& vector) {
        for (const Value value : vector) put(value);
    }
    void put(const types::Color& color) {
        for (const std::uint8_t channel : color) put(channel);
    }
    // Puts a text that ends with a zero.
    void put_text(std::string_view text) { bytes_.append(text).push_back('\0'); }
    // Puts a field of a fixed size: the text, cut to fit, and zeros.
    void put_field(std::string_view text, std::size_t size_bytes) {
        const std::size_t end = bytes_.size() + size_bytes;
        bytes_.append(text.substr(0, size_bytes)).resize(end, '\0');
    }
    void put_zeros(std::size_t size_bytes) { bytes_.append(size_bytes, '\0'); }
    std::size_t size_bytes() const { return bytes_.size(); }
    std::string_view bytes() const { return bytes_; }
    // Writes the values to a file, such as AtomicFile, and starts anew.
    template <typename File>
    void flush_to(File& file) {
        file.write(bytes_);
        bytes_.clear();
    }

private:
    std::string bytes_;
};

}  // namespace divemesh::io
