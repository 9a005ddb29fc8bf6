#pragma once

#include <cstdint>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_images.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::texture {

inline constexpr std::int32_t kNoView = -1;

// The keyframe that each triangle takes its colour from: an index into the keyframes, or kNoView.
using FaceViews = std::vector<std::int32_t>;

// The views that were chosen, and what they were chosen without.
struct ChosenFaceViews {
    FaceViews face_views;          // one per triangle
    std::vector<int> lost_frames;  // frame indices of the keyframes whose images cannot be read
};

// Chooses the keyframe that shows each triangle best: many pixels of a sharp image, from the front
// and from near. Left out are keyframes in which the triangle is hidden or not all in the image,
// and those that show something else there, such as a fish (drop_inconsistent_views()). Neighbours
// take the same keyframe where it costs little (smooth_views()). `read_image` returns CV_8UC3 or
// grey images. Keyframes whose images cannot be read are left out.
// Throws Error{TooLarge} for more than 65,535 keyframes or 500 million triangles.
ChosenFaceViews choose_face_views(const types::Mesh& mesh,
                                  const types::RectifiedRig& rig,
                                  const std::vector<types::Keyframe>& keyframes,
                                  const keyframes::ReadImage& read_image,
                                  int num_threads,
                                  const base::ProgressCallback& progress);

}  // namespace divemesh::texture
