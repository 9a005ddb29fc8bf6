#pragma once

#include "worker/base/observer.hpp"
#include "worker/texture/face_views.hpp"
#include "worker/texture/pack_cutouts.hpp"
#include "worker/texture/photographs.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/texture.hpp"

namespace divemesh::texture {

// Cuts the photographs along the charts of the mesh, levels their seams and packs them into
// atlases. A triangle without a view stays untextured, as does one behind its camera or beyond
// memory, or whose image cannot be read; `views` index the keyframes of `photographs`. Reads every
// image twice and holds one per thread. The result does not depend on `num_threads`. Throws
// Error{InvalidArgument} on wrong views or limits.
types::Texture texture_mesh(const types::Mesh& mesh,
                            const FaceViews& views,
                            const Photographs& photographs,
                            const AtlasOptions& options,
                            int num_threads,
                            const base::ProgressCallback& progress);

}  // namespace divemesh::texture
