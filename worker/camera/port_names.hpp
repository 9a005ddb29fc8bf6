#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "worker/types/port.hpp"

namespace divemesh::camera {

// How files and people name the shapes of ports, in the order of types::Port::Shape.
inline constexpr std::array<std::string_view, 2> kPortNames = {"flat", "dome"};

inline std::string_view port_name(types::Port::Shape shape) {
    return kPortNames[static_cast<std::size_t>(shape)];
}

// Returns the shape of a name; nullopt if no shape has it.
inline std::optional<types::Port::Shape> port_shape(std::string_view name) {
    for (std::size_t i = 0; i < kPortNames.size(); ++i)
        if (kPortNames[i] == name) return static_cast<types::Port::Shape>(i);
    return std::nullopt;
}

}  // namespace divemesh::camera
