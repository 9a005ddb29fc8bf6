#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "worker/io/geographic_frame.hpp"

namespace divemesh::io {

// What a LAS file states besides its points.
struct LasDescription {
    std::optional<UtmFrame> utm;                      // nullopt: the world's own coordinates
    std::string text;                                 // one line of ASCII about the file
    std::optional<std::chrono::year_month_day> date;  // nullopt: unknown
};

// How the points of the file are stored: one by one, or compressed (LAZ).
enum class LasStorage { Plain, Laszip };

// What the integers of the points mean: steps of 0.1 mm from `origin_m`; and the points' bounds.
struct LasGrid {
    static constexpr double kStep_m = 1e-4;

    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d low_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d high_m = Eigen::Vector3d::Zero();
};

// Returns all that precedes the points of a LAS 1.4 file (ASPRS, revision 15): the public header
// block and the variable length records, which hold the coordinate system as well-known text, the
// text, what the extra bytes are and, of a LAZ file, the compressor.
std::string las_header(const LasGrid& grid,
                       const LasDescription& description,
                       std::uint64_t num_points,
                       LasStorage storage);

}  // namespace divemesh::io
