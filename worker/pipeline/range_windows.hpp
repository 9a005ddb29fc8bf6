#pragma once

#include <optional>
#include <vector>

#include "worker/calibration/range_problem.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/types/exposure_motion.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::pipeline {

// Returns the camera's motion between the exposures of a frame's images, by features tracked to the
// next frame; nullopt if the images were exposed together, or too few features agree on a motion.
std::optional<types::ExposureMotion> exposure_motion_at(const types::Recording& recording,
                                                        const camera::Rectifier& rectifier,
                                                        const types::StereoFrame& frame);

// Returns features tracked for half a second from each of these frames on, with disparity at both
// ends, by steps 1 to 4 of the paper. A window in which too few features agree on a motion, in
// which the rig rests, or that runs to `end_frame`, has no matches.
std::vector<calibration::RangeWindow> track_windows(const types::Recording& recording,
                                                    const camera::Rectifier& rectifier,
                                                    const std::vector<int>& first_frames,
                                                    int end_frame,
                                                    int num_threads);

}  // namespace divemesh::pipeline
