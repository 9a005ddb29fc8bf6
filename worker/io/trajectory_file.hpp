#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "worker/types/recording.hpp"

namespace divemesh::io {

// tum: timestamp [s] x y z qx qy qz qw; euroc: timestamp [ns], x, y, z, qw, qx, qy, qz, ...; kitti:
// the upper three rows of the pose's matrix, without timestamps.
enum class TrajectoryFormat { Tum, Euroc, Kitti };

std::string_view to_string(TrajectoryFormat format);

// A trajectory as read, with the format of its file.
struct TrajectoryFile {
    TrajectoryFormat format = TrajectoryFormat::Tum;
    types::Trajectory poses;  // kitti: timestamp_ns is the index of the pose
};

// Writes the tum format. Timestamps keep their nanoseconds; positions and quaternions have nine
// decimals. A remark is a comment of one line at the top.
void write_tum(const std::filesystem::path& file,
               const types::Trajectory& trajectory,
               const std::string& remark = "");
// Writes the first eight columns of EuRoC's state_groundtruth_estimate0/data.csv, at the same
// precision.
void write_euroc(const std::filesystem::path& file, const types::Trajectory& trajectory);
// Writes one row per pose with nine decimals; the format has no timestamps.
void write_kitti(const std::filesystem::path& file, const types::Trajectory& trajectory);

// Reads a trajectory; detects its format from the first line that contains numbers. Throws
// Error{NotFound}, or Error{BadData} with file and line for a value that is not a number, a
// quaternion or matrix that is not a rotation, or timestamps that do not rise.
TrajectoryFile read_trajectory(const std::filesystem::path& file);

}  // namespace divemesh::io
