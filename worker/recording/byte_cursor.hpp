#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>

namespace divemesh::recording {

static_assert(std::endian::native == std::endian::little);

// Takes values from the front of little-endian bytes. Returns nullopt, and takes no byte, where the
// bytes end before the value does, so a hostile length is never more than an answer.
class ByteCursor {
public:
    explicit ByteCursor(std::string_view bytes) : bytes_(bytes) {}

    template <typename Value>
    std::optional<Value> take() {
        static_assert(std::is_arithmetic_v<Value>);
        if (bytes_.size() < sizeof(Value)) return std::nullopt;
        Value value;
        std::memcpy(&value, bytes_.data(), sizeof value);
        bytes_.remove_prefix(sizeof value);
        return value;
    }

    std::optional<std::string_view> take_bytes(std::uint64_t num_bytes) {
        if (num_bytes > bytes_.size()) return std::nullopt;
        const std::string_view taken = bytes_.substr(0, num_bytes);
        bytes_.remove_prefix(num_bytes);
        return taken;
    }

    // Takes bytes that a number of type Size in front of them counts.
    template <typename Size>
    std::optional<std::string_view> take_sized() {
        const std::string_view before = bytes_;
        const auto size = take<Size>();
        const auto taken = size ? take_bytes(*size) : std::nullopt;
        if (!taken) bytes_ = before;
        return taken;
    }

    std::string_view rest() const { return bytes_; }
    bool at_end() const { return bytes_.empty(); }

private:
    std::string_view bytes_;
};

}  // namespace divemesh::recording
