#pragma once

#include <filesystem>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes a glTF 2.0 binary: one mesh with positions, normals, vertex colours and 32-bit indices.
// The buffers keep our z-up metres; the node's rotation converts them to glTF's y-up. Colours are
// converted from sRGB to linear values, as COLOR_0 requires, in 16 bits so that dark water keeps
// its shades. The material is unlit, as the images contain the light already. Throws as AtomicFile
// and check_mesh do, and Error{TooLarge} beyond the format's 4 GiB.
void write_glb(const std::filesystem::path& file, const types::Mesh& mesh);

}  // namespace divemesh::io
