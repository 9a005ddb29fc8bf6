#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace divemesh::fuzz {

// The bytes of a fuzzer, consumed from the front.
class Input {
public:
    Input(const std::uint8_t* data, std::size_t size)
        : rest_(reinterpret_cast<const char*>(data), size) {}

    // Consumes one byte and returns a choice from 0 to num_choices - 1.
    std::size_t choice(std::size_t num_choices) {
        const auto byte = static_cast<unsigned char>(rest_.empty() ? '\0' : rest_.front());
        rest_.remove_prefix(rest_.empty() ? 0 : 1);
        return byte % num_choices;
    }
    std::string_view line() {
        const auto text = rest_.substr(0, rest_.find('\n'));
        rest_.remove_prefix(text.size() == rest_.size() ? text.size() : text.size() + 1);
        return text;
    }
    std::string_view rest() const { return rest_; }
    bool empty() const { return rest_.empty(); }

private:
    std::string_view rest_;
};

}  // namespace divemesh::fuzz
