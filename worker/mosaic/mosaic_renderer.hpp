#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/types/mesh.hpp"
#include "worker/types/raster_grid.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::mosaic {

// Some rows of a mosaic.
struct MosaicRows {
    cv::Mat color;     // CV_8UC4 BGRA; alpha 0 where there is no surface
    cv::Mat height_m;  // CV_32F, world z of the highest surface; NaN where there is none
    cv::Mat sigma_m;   // CV_32F, standard deviation of that surface; NaN where it is not known
};

// Renders a mosaic by rows, so that it need not fit into memory; the highest surface is visible. A
// triangle that `texture` (may be null) has no photograph of gets the colours of its vertices, grey
// if these have none. Mesh and texture must outlive the renderer. Threads do not change the pixels.
class MosaicRenderer {
public:
    MosaicRenderer(const types::Mesh& mesh,
                   const types::Texture* texture,
                   const types::RasterGrid& grid,
                   int num_threads);

    MosaicRows rows(int first_row, int num_rows) const;

private:
    void sort_triangles();

    const types::Mesh& mesh_;
    const types::Texture* texture_;
    types::RasterGrid grid_;
    int num_threads_;
    // The triangles of each group of rows, in their order: those of group i are at [begin_of_group_
    // [i], begin_of_group_[i + 1]).
    std::vector<std::size_t> begin_of_group_;
    std::vector<std::uint32_t> triangles_of_groups_;
};

}  // namespace divemesh::mosaic
