#pragma once

#include <array>
#include <vector>

namespace divemesh::color {

// What is rendered as white, r g b.
struct WhitePoint {
    std::array<double, 3> white = {1.0, 1.0, 1.0};  // in the units of the colours of the surface
    // In units of the median colour of the surface: this does not depend on light, exposure and
    // water, so that a later dive of the same place can be rendered alike.
    std::array<double, 3> relative = {1.0, 1.0, 1.0};
};

// Returns the white point of a surface by its colours, each of an equal area: "shades of grey"
// (Finlayson and Trezzi, "Shades of gray and colour constancy", 2004) takes the mean of the
// colours, with the bright ones counting more, to be grey. It is an assumption: three channels do
// not tell the colour of the light from that of the surface.
WhitePoint white_point_of(const std::vector<std::array<double, 3>>& surface);

// Returns the white point by that of an earlier dive, relative to the median of this surface.
WhitePoint white_point_like(const std::array<double, 3>& relative,
                            const std::vector<std::array<double, 3>>& surface);

}  // namespace divemesh::color
