#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::mosaic {

// Where a pixel lies in a triangle: the weights of the corners at its centre, and their change from
// one column to the next and from one row to the next.
struct PixelFootprint {
    Eigen::Vector3d weights;
    Eigen::Vector3d along_row;
    Eigen::Vector3d along_column;
};

// Returns the colour (b g r) of a pixel of a triangle: of its photograph, interpolated between
// texels, and averaged over the pixel if that covers several; of its vertices where `texture` is
// null or has none for it.
Eigen::Vector3f surface_color(const types::Mesh& mesh,
                              const types::Texture* texture,
                              std::size_t triangle,
                              const PixelFootprint& pixel);

}  // namespace divemesh::mosaic
