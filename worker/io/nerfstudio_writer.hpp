#pragma once

#include <filesystem>
#include <string>

#include "worker/io/posed_images.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes transforms.json and points.ply into a folder, as
// https://docs.nerf.studio/quickstart/data_conventions.html describes them. transform_matrix maps
// the camera, with OpenGL's axes (x right, y up, z back), to the world, in metres, z up. The camera
// is OPENCV, which nerfstudio, instant-ngp and gsplat know, without distortion. The images are
// those in images/ of the folder. Each of `points` has a colour. `remark` is a comment of one line
// in points.ply. Throws as AtomicFile does.
void write_nerfstudio(const std::filesystem::path& folder,
                      const PosedImages& images,
                      const types::Mesh& points,
                      const std::string& remark);

}  // namespace divemesh::io
