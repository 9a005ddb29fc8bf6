#pragma once

#include <vector>

#include "worker/camera/rerectifier.hpp"
#include "worker/markers/locate_markers.hpp"
#include "worker/base/parallel.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::worker {

// Looks for tags in both rectified pictures of every keyframe, reading the recording once more from
// its start. `refined`: moves what is read to where it would be with the lenses that the keyframes'
// poses were adjusted with; null: the stated ones. The result does not depend on `num_threads`.
std::vector<TagView> find_tags_in(Recording& recording,
                                  const std::vector<Keyframe>& keyframes,
                                  MarkerFamily family,
                                  const Rerectifier* refined,
                                  const ProgressShare& progress,
                                  int num_threads);

// Markers, bars and scale of what was seen, with findings: tags seen too few times, read in two
// places, bars that cannot be measured or contradict the others, a scale that is off.
MarkerMetrics measure_markers(const std::vector<TagView>& views,
                              const MarkerPlan& plan,
                              const MarkerWorld& world);

}  // namespace divemesh::worker
