#pragma once

#include <vector>

#include "worker/base/observer.hpp"
#include "worker/keyframes/keyframe_images.hpp"
#include "worker/pipeline/texture_metrics.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::pipeline {

// The surface as viewers show it.
struct DisplayMesh {
    types::Mesh mesh;
    types::Texture texture;
    TextureMetrics metrics;
};

// Returns the surface simplified within half of each vertex's standard deviation, which nobody sees
// and viewers need, and textured with the photographs of the keyframes. `surface` must not be
// empty. Both readers return images at the rig's size: `recorded` those by which a keyframe is
// chosen for each triangle, `shown` those that the texture is cut from.
DisplayMesh make_display_mesh(const types::Mesh& surface,
                              const types::RectifiedRig& rig,
                              const std::vector<types::Keyframe>& keyframes,
                              const keyframes::ReadImage& recorded,
                              const keyframes::ReadImage& shown,
                              int num_threads,
                              const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
