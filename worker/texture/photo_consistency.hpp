#pragma once

#include "worker/base/parallel.hpp"
#include "worker/texture/face_candidates.hpp"
#include "worker/texture/face_graph.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::texture {

// Drops the candidates that show something other than the triangle, such as a fish: those whose
// colour is an outlier among the candidates of the triangle, or of a neighbour, since the border of
// a fish is a mixture. This is the test of Waechter et al. (2014) with median and median absolute
// deviation in place of a mean shift, after the gain of each keyframe and the attenuation by the
// water are removed. With one or two candidates it cannot be said which is wrong: they stay, unless
// a neighbour knows. The last candidate of a triangle always stays.
void drop_inconsistent_views(const types::Mesh& mesh,
                             const std::vector<types::Keyframe>& keyframes,
                             const FaceGraph& graph,
                             int num_threads,
                             const base::ProgressShare& progress,
                             FaceCandidates& candidates);

}  // namespace divemesh::texture
