#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "worker/io/posed_images.hpp"
#include "worker/types/mesh.hpp"

// Messages of Foxglove's schemas (docs.foxglove.dev/docs/sdk/schemas) in JSON.
namespace divemesh::io {

// The JSON schema of a message: names of its fields with their types.
nlohmann::json foxglove_schema(std::string_view name);

nlohmann::json pose_in_frame(std::int64_t timestamp_ns,
                             const std::string& frame,
                             const Eigen::Isometry3d& T_frame_body);

nlohmann::json frame_transform(std::int64_t timestamp_ns,
                               const std::string& parent,
                               const std::string& child,
                               const Eigen::Isometry3d& T_parent_child);

// Positions as floats and colours as bytes; the mesh has a colour for each vertex.
nlohmann::json point_cloud(std::int64_t timestamp_ns,
                           const std::string& frame,
                           const types::Mesh& points);

nlohmann::json compressed_image(std::int64_t timestamp_ns,
                                const std::string& frame,
                                std::string_view jpeg);

// The pinhole camera of rectified images, whose first pixel has its centre at (0, 0).
nlohmann::json camera_calibration(std::int64_t timestamp_ns,
                                  const std::string& frame,
                                  const PosedImages& images);

}  // namespace divemesh::io
