#pragma once

#include <string>
#include <utility>

#include "api/client/byte_source.hpp"

namespace divemesh {

class BytesInMemory : public api::client::ByteSource {
public:
    explicit BytesInMemory(std::string bytes) : bytes_(std::move(bytes)) {}
    std::int64_t size_bytes() const override { return static_cast<std::int64_t>(bytes_.size()); }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        return bytes_.copy(buffer.data(), buffer.size(), static_cast<std::size_t>(offset));
    }

private:
    std::string bytes_;
};

}  // namespace divemesh
