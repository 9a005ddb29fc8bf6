#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>

#include "worker/compare/area_changes.hpp"

namespace divemesh::compare {

// The change that counts as full colour in pictures: 95 % of all significant change is less, 20 mm
// at least.
double full_change_m(const ChangeMap& map);

// From above, BGR: b in faint grey, changed cells red (lost) to blue (grown), patches outlined and
// numbered; ground of one dive alone is paler, hidden ground hatched, the rest white. Outlines with
// their marks in green (earlier dive) and violet (later). Lines and letters are such that they can
// be seen when the picture is shown `kDisplaySide_px` long.
inline constexpr int kDisplaySide_px = 1100;
cv::Mat draw_changes(const types::Mesh& b,
                     const ChangeMap& map,
                     const Changes& changes,
                     const std::vector<ComparedOutline>& outlines,
                     double full_m);

// A surface from above on the map's grid, in its own colours.
cv::Mat draw_surface(const types::Mesh& mesh, const RasterGrid& grid);

// mosaic_difference.png with mosaic_difference.json (scale, meaning of colours), and
// change_height.png: 16 bit, the height of b over a; the .json says how.
void write_difference(const std::filesystem::path& folder,
                      const cv::Mat& image,
                      const ChangeMap& map,
                      bool has_outlines,
                      double full_m);

std::string encode_png(const cv::Mat& image);
std::string encode_jpeg(const cv::Mat& image, int max_side_px);

}  // namespace divemesh::compare
