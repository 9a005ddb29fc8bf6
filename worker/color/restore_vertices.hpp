#pragma once

#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/color/restorer.hpp"
#include "worker/color/surface_sightings.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::color {

// The colours of a mesh's vertices without water.
struct RestoredVertices {
    std::vector<types::Color> colors;  // one per vertex
    double limited_share = 0.0;        // of the sightings of vertices: RestoredColor::is_limited
};

// Returns the colours of all vertices as the mean of what the keyframes show of them, restored; the
// less a sighting is amplified, the more it counts. Vertices that no keyframe shows take the
// colours of their neighbours, or keep theirs. Throws std::logic_error if surface.mesh has no
// normals.
RestoredVertices restore_vertices(const SeenSurface& surface,
                                  const std::vector<types::Keyframe>& keyframes,
                                  const ReadKeyframe& read,
                                  const Restorer& restorer,
                                  int num_threads,
                                  const base::ProgressShare& progress);

}  // namespace divemesh::color
