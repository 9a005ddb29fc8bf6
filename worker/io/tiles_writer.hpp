#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "worker/io/textured_mesh.hpp"
#include "worker/types/geographic_position.hpp"

namespace divemesh::io {

// How a mesh is cut into tiles, and what the tileset states besides them.
struct TilesDescription {
    std::optional<types::GeographicPosition> position;  // nullopt: the world's own coordinates
    std::string text;                                   // about the file
    std::size_t max_triangles = 40'000;                 // of a tile, as far as its border allows
    std::int64_t max_texels = std::int64_t{1} << 22;    // of a tile, as far as its charts allow
};

// Writes a mesh as 3D Tiles 1.1 (OGC 22-025r4): tileset.json and a GLB with
// EXT_meshopt_compression for each tile. The tiles are a quadtree seen from above, whose leaves
// have all triangles and the texels of the atlases. A tile above is what is below it, simplified
// with its border and the seams of its texture kept, so that neighbours of different detail meet
// without a crack; its texture is halved at least once more than those below. With a null texture
// tiles have the colours of the vertices.
// The geometricError of a tile is the quadric error of its simplification added to the largest
// below, or 16 of its texels if its texture is halved and that is more: a viewer that refines at an
// error of 16 px, as is the custom, so shows texels of up to a pixel. `extras` states both.
// With a position the root's transform turns our world into earth-centred coordinates, the first
// pose at height 0 of the ellipsoid; without north the y axis is taken for it. The same mesh gives
// the same bytes. One tile at a time is in memory, besides the mesh and its atlases. Throws as
// write_glb and AtlasImages do.
void write_tiles(const std::filesystem::path& folder,
                 const types::Mesh& mesh,
                 const StoredTexture* texture,
                 const TilesDescription& description);

}  // namespace divemesh::io
