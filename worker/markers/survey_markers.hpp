#pragma once

#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/camera/rerectifier.hpp"
#include "worker/markers/locate_markers.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::markers {

// Returns the tags in both rectified images of every keyframe, or in the left one alone where the
// right one was exposed at another time; reads the recording again from its start. `refined` moves
// the corners to where they would be with the lenses that were refined together with the keyframes'
// poses; null: the stated lenses. The result does not depend on `num_threads`.
std::vector<TagView> find_tags_in(types::Recording& recording,
                                  const std::vector<types::Keyframe>& keyframes,
                                  dive::MarkerFamily family,
                                  const camera::Rerectifier* refined,
                                  const base::ProgressShare& progress,
                                  int num_threads);

// Returns markers, bars and scale from the views, with findings: tags seen too few times or in two
// places, bars that cannot be measured or contradict the others, a scale that is off.
MarkerMetrics measure_markers(const std::vector<TagView>& views,
                              const dive::MarkerPlan& plan,
                              const MarkerWorld& world);

}  // namespace divemesh::markers
