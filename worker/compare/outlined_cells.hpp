#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/compare/surface_raster.hpp"
#include "worker/reef/area_set.hpp"
#include "worker/reef/polygon.hpp"

namespace divemesh::compare {

// The outline of a quadrat or a polygon as seen from above: x and y of its corners. Throws
// Error{BadData} that names the area when from above it has no area or its sides cross.
reef::Polygon outline_from_above(const reef::Area& area);

// In cells of the map: x along columns, y along rows, whole at the cells' sides.
reef::Polygon in_cells(const reef::Polygon& outline, const RasterGrid& grid);

// Cells of a map whose middle lies within an outline.
struct OutlinedCells {
    cv::Rect window;  // of the map, empty when the outline lies beside it
    cv::Mat cells;    // CV_8U, of the window's size

    int num_on(const cv::Mat& map) const;  // that a map (CV_8U) names too
    void add_to(cv::Mat& map) const;
};

OutlinedCells cells_within(const reef::Polygon& outline, const RasterGrid& grid);

// Of an outline with that area the share that a map names; what lies beside the map counts as not.
double share_on(const OutlinedCells& within, double area_m2, const cv::Mat& map, double cell_m);

}  // namespace divemesh::compare
