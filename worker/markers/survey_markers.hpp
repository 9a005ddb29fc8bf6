#pragma once

#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/camera/rerectifier.hpp"
#include "worker/markers/locate_markers.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::markers {

// Looks for tags in both rectified pictures of every keyframe, reading the recording once more from
// its start. `refined`: moves what is read to where it would be with the lenses that the keyframes'
// poses were adjusted with; null: the stated ones. The result does not depend on `num_threads`.
std::vector<TagView> find_tags_in(types::Recording& recording,
                                  const std::vector<types::Keyframe>& keyframes,
                                  dive::MarkerFamily family,
                                  const camera::Rerectifier* refined,
                                  const base::ProgressShare& progress,
                                  int num_threads);

// Markers, bars and scale of what was seen, with findings: tags seen too few times, read in two
// places, bars that cannot be measured or contradict the others, a scale that is off.
MarkerMetrics measure_markers(const std::vector<TagView>& views,
                              const dive::MarkerPlan& plan,
                              const MarkerWorld& world);

}  // namespace divemesh::markers
