#pragma once

#include <functional>
#include <vector>

#include "worker/dive/dive_contents.hpp"
#include "worker/dive/frame_reader.hpp"
#include "worker/dive/hand_eye.hpp"

namespace divemesh::dive {

// Looks at a dozen moments of the dive where the gyro turns most: do left and right stand as the
// calibration says, do gyro and pictures turn alike? Pictures without matching features say
// nothing. `load` gives the pair of an index.
void check_motion(const DiveContents& contents,
                  const std::function<LoadedPair(int index)>& load,
                  const base::ProgressCallback& progress,
                  FindingLog& findings);

}  // namespace divemesh::dive
