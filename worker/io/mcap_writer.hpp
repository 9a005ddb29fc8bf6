#pragma once

#include <filesystem>
#include <string>

#include "worker/io/reconstruction_folder.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes a reconstruction as MCAP for Foxglove: /pose (foxglove.PoseInFrame) and /tf
// (FrameTransform from world to body) of every tracked frame, /cloud (PointCloud), and for each
// keyframe /cam0/image (CompressedImage), /cam0/calibration and its /tf from world to cam0.
// `cloud` has a colour for each vertex, `remark` is a text about the file. Throws as the readers of
// the reconstruction and AtomicFile do.
void write_mcap(const std::filesystem::path& file,
                const ReconstructionFolder& reconstruction,
                const types::Mesh& cloud,
                const std::string& remark);

}  // namespace divemesh::io
