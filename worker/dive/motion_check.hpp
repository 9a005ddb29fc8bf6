#pragma once

#include <functional>
#include <vector>

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/frame_reader.hpp"
#include "worker/dive/hand_eye.hpp"

namespace divemesh::dive {

// Checks about a dozen moments of the dive where the gyro rotates most: whether left and right
// images fit the calibration, and whether gyro and images show the same rotation. Images without
// matching features are ignored; those of more than 960 px of width are reduced. `load` returns the
// pair of an index, or its left image alone; several threads call it at once.
void check_motion(const DiveContents& contents,
                  const std::function<LoadedPair(int index, Eyes eyes)>& load,
                  const base::ProgressCallback& progress,
                  FindingLog& findings);

}  // namespace divemesh::dive
