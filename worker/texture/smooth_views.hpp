#pragma once

#include "worker/base/parallel.hpp"
#include "worker/texture/face_views.hpp"
#include "worker/texture/view_field.hpp"

namespace divemesh::texture {

// Returns views of low energy, by loopy belief propagation (min-sum, with the linear messages of
// the Potts model: Felzenszwalb and Huttenlocher 2006), then iterated conditional modes (Besag
// 1986). The same whatever the number of threads; linear in memory and time.
FaceViews smooth_views(const ViewField& field,
                       int num_threads,
                       const base::ProgressShare& progress);

// Gives each triangle the view of least energy beside the views of its neighbours, until none
// changes.
void descend(const ViewField& field, int num_threads, FaceViews& views);

}  // namespace divemesh::texture
