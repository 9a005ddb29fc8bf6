#pragma once

#include "worker/calibration/range_problem.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/rig_alignment.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::calibration {

// Returns the pose of the right camera relative to the left one, from the rows of matches of pairs
// that were rectified with the stated calibration; those of a pair must follow each other. The
// length of the baseline stays as stated: images alone do not determine it. Pitch, roll, direction
// of the baseline and focal length are estimated where they are significant. An outcome `Moved`
// means that the change is large enough to matter.
types::RigAlignment estimate_rig_alignment(const types::Rig& rig,
                                           const types::RectifiedRig& rectified,
                                           const types::StereoMatches& matches);

// Returns the part of a dive whose matches these are, with the turn of the right camera against
// `rig`: pitch, roll and focal length from rows, as above. A knock turns the camera; what it does
// to the baseline is too small to be told.
types::RigPart estimate_turn(const types::Rig& rig,
                             const types::RectifiedRig& rectified,
                             const types::StereoMatches& matches);

// Adds to the change of a right camera a rotation about the row axis of the images that are
// rectified with `rig`, in which the change is applied.
void add_yaw(const types::Rig& rig, double yaw_rad, types::RigChange::Vector& change);

// The expected values of what bends ranges, after careful calibrations, and their sigmas.
RangeUnknowns expected_ranges();
RangeUnknowns expected_range_sigmas();

// Adds yaw and principal point of the right camera to the alignment, if ranges of windows rectified
// with it show that all disparities are biased: significantly, and enough to matter for the scale.
// A failed solution adds only that it failed. `rectified` is what the windows were rectified to.
void add_ranges(const types::Rig& rig,
                const types::RectifiedRig& rectified,
                const RangeSolution& ranges,
                types::RigAlignment& alignment);

// Returns the rig with both cameras in another medium than that of the calibration.
types::Rig rig_in_medium(const types::Rig& rig, const types::MediumChange& medium);

// Returns the rig in the medium of the dive and with the right camera moved; the left one stays
// where it is on the body.
types::Rig changed_rig(const types::Rig& rig, const types::RigChange& change);

}  // namespace divemesh::calibration
