#pragma once

#include <vector>

#include "worker/color/keyframe_view.hpp"
#include "worker/color/restorer.hpp"
#include "worker/keyframes/keyframe_images.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::color {

// Returns what reads the images of the keyframes without water, by the range of the surface in each
// pixel. Beside the surface the range is that of the nearest pixel on it. Mesh, rig and keyframes
// must outlive it; `read` returns CV_8UC3 of the rig's size.
keyframes::ReadImage restored_images(const types::Mesh& mesh,
                                     const types::RectifiedRig& rig,
                                     const std::vector<types::Keyframe>& keyframes,
                                     const keyframes::ReadImage& read,
                                     Restorer restorer);

}  // namespace divemesh::color
