#pragma once

#include <string>
#include <vector>

#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::io {

// A texture whose atlases are as a file has them.
struct StoredTexture : types::TextureMap {
    std::vector<std::string> jpegs;
};

// Returns the name of an atlas beside a mesh that refers to it.
inline std::string atlas_file_name(std::size_t atlas) {
    return "atlas_" + std::to_string(atlas) + ".jpg";
}

// A mesh as viewers show it.
struct TexturedMesh {
    types::Mesh mesh;
    StoredTexture texture;
};

}  // namespace divemesh::io
