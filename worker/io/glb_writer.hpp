#pragma once

#include <filesystem>

#include "worker/types/mesh.hpp"

namespace divemesh::io {

// glTF 2.0 binary: one mesh with positions, normals, vertex colours and 32-bit indices. Our z-up
// metres stay in the buffers; the node's rotation turns them into glTF's y-up. Colours are
// converted from sRGB to the linear values COLOR_0 wants, in 16 bits so that dark water keeps its
// shades. Unlit: the light is in the pictures already. Throws as AtomicFile and check_mesh do,
// and Error{TooLarge} beyond the format's 4 GiB.
void write_glb(const std::filesystem::path& file, const types::Mesh& mesh);

}  // namespace divemesh::io
