#pragma once

#include <filesystem>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::io {

// How the vertices and triangles of a GLB are stored.
enum class GlbCompression {
    None,       // floats; every reader of glTF 2.0 opens it
    Quantised,  // integers of 8 and 16 bits (KHR_mesh_quantization)
    Meshopt     // the same, compressed (EXT_meshopt_compression)
};

// Writes a glTF 2.0 binary: a primitive for each atlas that is in use, with its image as JPEG of
// quality 90, and one with vertex colours for the triangles without texture; without texture
// (null), one for all. Quantised positions are on the position_lattice() of the mesh, texture
// coordinates within 1/16 px of a texel of the largest atlas, normals within half a degree; the
// file states the largest error of a position as asset.extras.max_position_error_m. Triangles and
// vertices are in the order that is fastest to draw. The node turns our z-up metres into glTF's
// y-up. Vertex colours are converted from sRGB to linear values, as COLOR_0 requires, in 16 bits so
// that dark water keeps its shades. The materials are unlit, as the images contain the light
// already. Throws as AtomicFile, check_mesh and check_texture do, and Error{TooLarge} beyond the
// format's 4 GiB.
void write_glb(const std::filesystem::path& file,
               const types::Mesh& mesh,
               const types::Texture* texture,
               GlbCompression compression);

}  // namespace divemesh::io
