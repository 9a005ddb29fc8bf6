#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

#include "worker/compare/area_changes.hpp"

namespace divemesh::compare {

// Returns the change that gets full colour in images: 95 % of all significant change is smaller; 20
// mm at least.
double full_change_m(const ChangeMap& map);

// Draws the change from above, BGR: b in faint grey, changed cells red (lost) to blue (grown),
// patches outlined and numbered. Ground that one dive alone saw is paler, hidden ground is hatched,
// the rest white. Outlines have their marks in green (earlier dive) and violet (later). Lines and
// letters are visible when the image is shown with its longer side at `kDisplaySide_px`.
inline constexpr int kDisplaySide_px = 1100;
cv::Mat draw_changes(const types::Mesh& b,
                     const ChangeMap& map,
                     const Changes& changes,
                     const std::vector<ComparedOutline>& outlines,
                     double full_m);

// Draws a surface from above on the map's grid, in its own colours.
cv::Mat draw_surface(const types::Mesh& mesh, const RasterGrid& grid);

// Writes mosaic_difference.png with mosaic_difference.json (scale, meaning of colours), and
// change_height.png: 16 bit, the height of b over a, with the encoding in the .json.
void write_difference(const std::filesystem::path& folder,
                      const cv::Mat& image,
                      const ChangeMap& map,
                      bool has_outlines,
                      double full_m);

// Encode an image; the JPEG is scaled down to `max_side_px`.
std::string encode_png(const cv::Mat& image);
std::string encode_jpeg(const cv::Mat& image, int max_side_px);

}  // namespace divemesh::compare
