#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "worker/types/geographic_position.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// How a mesh is cut into tiles, and what the tileset states besides them.
struct TilesDescription {
    std::optional<types::GeographicPosition> position;  // nullopt: the world's own coordinates
    std::string text;                                   // about the file
    std::size_t max_triangles = 40'000;                 // of a tile, as far as its border allows
};

// Writes a mesh as 3D Tiles 1.1 (OGC 22-025r4): tileset.json and a GLB with
// EXT_meshopt_compression for each tile. The tiles are a quadtree seen from above, whose leaves
// have all triangles. A tile above is what is below it, simplified with its border locked, so that
// neighbours of different detail meet without a crack. Its geometricError is the quadric error of
// its simplification added to the largest below. With a position the root's transform turns our
// world into earth-centred coordinates, the first pose at height 0 of the ellipsoid; without north
// the y axis is taken for it. The same mesh gives the same bytes. Throws as write_glb does.
void write_tiles(const std::filesystem::path& folder,
                 const types::Mesh& mesh,
                 const TilesDescription& description);

}  // namespace divemesh::io
