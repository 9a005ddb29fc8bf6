#pragma once

#include <vector>

#include "worker/io/reconstruction_folder.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::compare {

// A dive that lost the scene is in tracking segments. Their relative positions are not known, so
// they lie side by side along x, in one mesh. Only the largest one, with the most frames, is
// compared.

// Returns the keyframes of the largest segment: all of a dive in one segment, and of an older
// version that states none.
std::vector<io::KeyframePose> compared_keyframes(const io::ReconstructionFolder& folder);

// Returns the surface in mesh.ply that the largest segment saw, without what a contradicted
// scale adds to its sigmas: that error is shared, and in no interval of a change. Throws
// Error{BadData} if the surface cannot be told from those of the others.
types::Mesh compared_surface(const io::ReconstructionFolder& folder);

}  // namespace divemesh::compare
