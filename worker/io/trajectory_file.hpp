#pragma once

#include <filesystem>
#include <string_view>

#include "worker/types/recording.hpp"

namespace divemesh::io {

// tum: timestamp [s] x y z qx qy qz qw; euroc: timestamp [ns], x, y, z, qw, qx, qy, qz, ...;
// kitti: the upper three rows of the pose's matrix, no stamps.
enum class TrajectoryFormat { Tum, Euroc, Kitti };

std::string_view to_string(TrajectoryFormat format);

struct TrajectoryFile {
    TrajectoryFormat format = TrajectoryFormat::Tum;
    types::Trajectory poses;  // kitti: timestamp_ns is the number of the pose, from 0
};

// Nanoseconds are kept; positions and quaternions have nine decimals.
void write_tum(const std::filesystem::path& file, const types::Trajectory& trajectory);
// The first eight columns of EuRoC's state_groundtruth_estimate0/data.csv, as precise.
void write_euroc(const std::filesystem::path& file, const types::Trajectory& trajectory);
// One row a pose, nine decimals; the stamps are lost, as that format has none.
void write_kitti(const std::filesystem::path& file, const types::Trajectory& trajectory);

// Finds out the format from the first line that holds numbers. Throws Error{NotFound}, or
// Error{BadData} with file and line: not a number, no rotation, stamps that do not rise.
TrajectoryFile read_trajectory(const std::filesystem::path& file);

}  // namespace divemesh::io
