#pragma once

#include <map>
#include <string>
#include <vector>

#include "worker/reef/polygon.hpp"

namespace divemesh::reef {

// What the coordinates of outlines are.
//   Unstated  the file does not tell
//   Earth     longitude and latitude or UTM, as `epsg` says
//   World     x and y of the reconstruction, m
//   Pixels    column and row of an image of the mosaic; the centre of the first pixel is (0, 0)
enum class OutlineCoordinates { Unstated, Earth, World, Pixels };

// A ring or a line that another program drew. A feature of several parts gives several of them.
struct Outline {
    std::size_t feature = 0;  // its place in the file, from 0
    bool is_line = false;
    Polygon points;  // a ring's last point is joined to its first
    int num_holes = 0;
    std::map<std::string, std::string> columns;  // what the file states of the feature
};

// The outlines of one file.
struct OutlineFile {
    OutlineCoordinates coordinates = OutlineCoordinates::Unstated;
    int epsg = 0;                                             // of Earth
    Eigen::Vector2d image_size_px = Eigen::Vector2d::Zero();  // of Pixels
    double pixel_m = 0.0;  // of Pixels; 0: the file does not tell
    std::vector<Outline> outlines;
};

// Limits of one file, so that a damaged one does not fill the memory.
inline constexpr std::size_t kMaxOutlinePoints = 5'000'000;

// The code of systems that have no place on the earth.
inline constexpr int kLocalCoordinates = -1;

// Returns the EPSG code of a coordinate system's name or of its well-known text; 0 for one that is
// neither WGS 84 in degrees or in UTM nor local.
int epsg_of(const std::string& text);

}  // namespace divemesh::reef
