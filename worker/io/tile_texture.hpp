#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/pack_rectangles.hpp"
#include "worker/io/atlas_images.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::io {

// The part of a texture that some triangles of its mesh use. Triangles that share a vertex must
// share its place in the texture: vertices are repeated at seams.
class TileTexture {
public:
    TileTexture(const types::Mesh& mesh, const types::TextureMap& map, AtlasImages& atlases);

    // Returns the number of texels that it has after halvings, with borders.
    std::int64_t num_texels(int num_halvings) const;
    // Returns the side of a texel on the surface, as it is in the atlases; 0 without texture.
    double texel_m() const;
    // Returns the part as a texture of its own, halved some times. Each chart is cut out with what
    // its triangles use, and goes on beyond their edge with the nearest texel, so that no other
    // chart shows in bilinear samples or small mip levels. Throws as AtlasImages does.
    types::Texture pack(int num_halvings) const;

private:
    // A connected part of the surface in one atlas.
    struct Chart {
        std::int32_t atlas = 0;
        cv::Rect pixels;  // that it uses
        std::vector<std::uint32_t> triangles;
    };

    std::vector<cv::Rect> bordered(int num_halvings) const;
    void fill(const std::vector<cv::Rect>& pixels,
              const base::RectanglePacking& packing,
              int num_halvings,
              types::Texture& packed) const;
    cv::Mat texels(const Chart& chart, const cv::Rect& pixels, int num_halvings) const;
    cv::Mat coverage(const Chart& chart, const cv::Rect& source) const;

    const types::Mesh& mesh_;
    const types::TextureMap& map_;
    AtlasImages& atlases_;
    std::vector<Chart> charts_;
};

}  // namespace divemesh::io
