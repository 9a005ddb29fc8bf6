#pragma once

#include <Eigen/Core>
#include <optional>

#include "worker/types/rectified_rig.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::calibration {

// A frame at which the rows of matching points jump, as they do when something knocks a camera. Row
// offsets (right minus left, px) are linear in where the left pixel lies; the part that grows with
// the disparity, of a baseline that points elsewhere than stated, is the same before and after.
struct RowJump {
    using Model = Eigen::Vector4d;  // of x, y (focal lengths), 1 and the disparity (focal lengths)

    int last_before = 0;  // frame indices
    int first_after = 0;
    double shift_px = 0.0;  // RMS over the points
    types::RectifiedRig rig;
    Model before = Model::Zero();
    Model after = Model::Zero();

    // Returns true if the rows of the matches of one pair are those before the jump; nullopt if
    // there are too few.
    std::optional<bool> is_before(const types::StereoMatches& matches) const;
    // Returns how far the rows of the matches of one pair have gone: 0 before the jump, 1 after it;
    // nullopt if there are too few.
    std::optional<double> share_after(const types::StereoMatches& matches) const;
};

// Returns the clearest jump between pairs of the matches; nullopt if nothing jumps. A jump is
// larger than 0.5 px, 0.0008 focal lengths and five times what the rows of whole pairs near it
// differ by on their own side, so that neither noise nor a slow bend is one.
std::optional<RowJump> find_row_jump(const types::RectifiedRig& rig,
                                     const types::StereoMatches& matches);

}  // namespace divemesh::calibration
