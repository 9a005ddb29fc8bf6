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
using FaceViews = std::vector<std::int32_t>;  // per triangle: index into the keyframes, or kNoView

FaceViews choose_face_views(const types::Mesh& mesh,
                            const types::RectifiedRig& rig,
                            const std::vector<types::Keyframe>& keyframes,
                            const keyframes::ReadImage& read_image,
                            int num_threads,
                            const base::ProgressCallback& progress);

}  // namespace divemesh::texture
