#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/compare/surface_raster.hpp"
#include "worker/reef/area_set.hpp"
#include "worker/reef/polygon.hpp"

namespace divemesh::compare {

// Returns the outline of a quadrat or a polygon from above: x and y of its corners. Throws
// Error{BadData}, which names the area, if it has no area from above or its sides cross.
reef::Polygon outline_from_above(const reef::Area& area);

// Returns the outline in cells of the map: x along columns, y along rows, integers at the cells'
// sides.
reef::Polygon in_cells(const reef::Polygon& outline, const RasterGrid& grid);

// The cells of a map whose centres lie within an outline.
struct OutlinedCells {
    cv::Rect window;  // of the map; empty if the outline lies outside it
    cv::Mat cells;    // CV_8U, of the window's size

    int num_on(const cv::Mat& map) const;  // that a map (CV_8U) also selects
    void add_to(cv::Mat& map) const;
};

// Returns the cells of the grid within an outline in metres.
OutlinedCells cells_within(const reef::Polygon& outline, const RasterGrid& grid);

// Returns the share of an outline of this area that a map selects; what lies outside the map does
// not count as selected.
double share_on(const OutlinedCells& within, double area_m2, const cv::Mat& map, double cell_m);

}  // namespace divemesh::compare
