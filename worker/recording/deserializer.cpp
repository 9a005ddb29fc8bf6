#include "worker/recording/deserializer.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "schemas/error.hpp"

namespace divemesh::recording {
namespace {

// In front of the fields of CDR: how they are represented, and options.
constexpr std::size_t kEncapsulation_bytes = 4;

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

}  // namespace

Deserializer::Deserializer(Serialization serialization, std::string_view bytes) : bytes_(bytes) {
    if (serialization == Serialization::Unknown)
        fail("its messages are neither those of ROS 1 nor CDR: record the topic by ROS");
    if (serialization == Serialization::Ros1) return;
    is_cdr_ = true;
    const std::string_view head = take_raw(kEncapsulation_bytes, "its representation");
    const int kind = static_cast<unsigned char>(head[0]) << 8 | static_cast<unsigned char>(head[1]);
    // Plain CDR is 0 and 1, plain CDR of version 2, which aligns to at most four bytes, 6 and 7.
    if (kind > 1 && kind != 6 && kind != 7)
        fail("its messages are represented as kind " + std::to_string(kind) +
             " of CDR, which is not read: record the topic by ROS 2");
    is_big_endian_ = kind % 2 == 0;
    max_alignment_bytes_ = kind > 1 ? 4 : 8;
    bytes_.remove_prefix(kEncapsulation_bytes);
    at_ = 0;
}

template <typename Value>
Value Deserializer::take() {
    align(sizeof(Value));
    char raw[sizeof(Value)];
    std::memcpy(raw, take_raw(sizeof raw, "a number").data(), sizeof raw);
    if (is_big_endian_) std::reverse(raw, raw + sizeof raw);
    Value value;
    std::memcpy(&value, raw, sizeof value);
    return value;
}

template std::uint8_t Deserializer::take();
template std::int32_t Deserializer::take();
template std::uint32_t Deserializer::take();
template double Deserializer::take();

std::string_view Deserializer::take_text() {
    std::string_view text = take_raw(take<std::uint32_t>(), "a text");
    if (is_cdr_ && text.ends_with('\0')) text.remove_suffix(1);
    return text;
}

std::string_view Deserializer::take_bytes() {
    return take_raw(take<std::uint32_t>(), "a list of bytes");
}

std::uint32_t Deserializer::take_length(std::size_t item_bytes) {
    const auto length = take<std::uint32_t>();
    if (length > (bytes_.size() - at_) / item_bytes)
        fail("the message ends in a list of " + std::to_string(length) + " items");
    return length;
}

std::string_view Deserializer::take_raw(std::uint64_t num_bytes, const char* what) {
    if (num_bytes > bytes_.size() - at_) {
        std::string text = "the message of ";
        text += std::to_string(bytes_.size());
        text += " bytes ends in ";
        text += what;
        fail(text);
    }
    const std::string_view taken = bytes_.substr(at_, num_bytes);
    at_ += num_bytes;
    return taken;
}

void Deserializer::align(std::size_t num_bytes) {
    if (!is_cdr_) return;
    const std::size_t step = std::min(num_bytes, max_alignment_bytes_);
    take_raw((step - at_ % step) % step, "a number");
}

}  // namespace divemesh::recording
