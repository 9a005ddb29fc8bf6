#pragma once

#include <cstddef>
#include <span>

namespace divemesh::api {

// The bytes of a body that are made while they are sent.
class BodySource {
public:
    virtual ~BodySource() = default;
    // Writes the next bytes into `bytes`, which is not empty; returns their number, 0 at the end.
    // Blocks: it is called in the pool. Throws if the body cannot be completed.
    virtual std::size_t read(std::span<char> bytes) = 0;
};

}  // namespace divemesh::api
