#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "worker/base/parallel.hpp"
#include "worker/color/keyframe_view.hpp"
#include "worker/color/sighting.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::color {

// Returns image and depth of a keyframe, as KeyframeStore::read(). Must be thread-safe.
using ReadKeyframe = std::function<types::KeyframeImages(int frame_index)>;

// Calls visit(keyframe, view) for each keyframe, one after the other; a few are decoded ahead.
// Those whose images cannot be read, or are not CV_8UC3 of the rig's size, or whose depth has
// another size, are left out; returns how many they are.
std::size_t for_each_view(const SeenSurface& surface,
                          const std::vector<types::Keyframe>& keyframes,
                          const ReadKeyframe& read,
                          int num_threads,
                          const base::ProgressShare& progress,
                          const std::function<void(std::size_t, const KeyframeView&)>& visit);

// Returns what the keyframes show of points that are spread evenly over the surface. The memory
// does not grow with the number of keyframes, as a point keeps a few sightings of all ranges.
Sightings surface_sightings(const SeenSurface& surface,
                            const std::vector<types::Keyframe>& keyframes,
                            const ReadKeyframe& read,
                            int num_threads,
                            const base::ProgressShare& progress);

}  // namespace divemesh::color
