#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "worker/recording/container.hpp"

namespace divemesh::recording {

// Takes the fields of a message one after the other: those of ROS 1, which lie one behind the
// other, or of CDR (OMG's common data representation, of ROS 2), which are aligned and state their
// byte order. Throws Error{BadData} that says what a message ends in, before memory is allocated
// for a length that it states.
class Deserializer {
public:
    Deserializer(Serialization serialization, std::string_view bytes);

    template <typename Value>
    Value take();  // of std::uint8_t, std::int32_t, std::uint32_t or double
    template <typename Value, std::size_t kSize>
    std::array<Value, kSize> take_array();
    std::string_view take_text();
    std::string_view take_bytes();  // a list of bytes
    // Takes the number of items of a list, each of which has at least `item_bytes`.
    std::uint32_t take_length(std::size_t item_bytes);
    bool is_ros1() const { return !is_cdr_; }

private:
    std::string_view take_raw(std::uint64_t num_bytes, const char* what);
    void align(std::size_t num_bytes);

    std::string_view bytes_;
    std::size_t at_ = 0;
    bool is_cdr_ = false;
    bool is_big_endian_ = false;
    std::size_t max_alignment_bytes_ = 8;
};

template <typename Value, std::size_t kSize>
std::array<Value, kSize> Deserializer::take_array() {
    std::array<Value, kSize> values{};
    for (Value& value : values) value = take<Value>();
    return values;
}

}  // namespace divemesh::recording
