#pragma once

#include <filesystem>
#include <string>

#include "worker/io/posed_images.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes a sparse model of COLMAP into a folder: cameras, images and points3D, each as .bin and as
// .txt, as https://colmap.github.io/format.html describes them. One PINHOLE camera; poses as
// rotation (Hamilton, w x y z) and translation from the world to the camera. COLMAP has no up and
// no unit: the world stays as in our files, in metres, z up.
//
// The points have no tracks and the error -1, COLMAP's "unknown": they are of the dense surface, no
// feature of an image was matched to them, and projected ones would pass for measurements with an
// error of zero. Trainers of splats need only poses and points; a program that chooses images by
// common points (COLMAP's patch_match_stereo) must be told which to use.
//
// Each of `points` has a colour. `remark` is a comment of one line in the text files. The same
// model gives the same bytes. Throws as AtomicFile does.
void write_colmap(const std::filesystem::path& folder,
                  const PosedImages& images,
                  const types::Mesh& points,
                  const std::string& remark);

}  // namespace divemesh::io
