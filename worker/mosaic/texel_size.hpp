#pragma once

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::mosaic {

// Returns the pixel size of a mosaic that shows what was seen, m: the median size on the surface of
// the texels on triangles that face upwards, rounded to 0.1 mm, from 0.5 to 2 mm. Without such
// texels it is half the mean edge of the mesh.
double seen_pixel_m(const types::Mesh& mesh, const types::Texture& texture);

}  // namespace divemesh::mosaic
