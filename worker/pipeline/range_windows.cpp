#include "worker/pipeline/range_windows.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/parallel.hpp"
#include "worker/base/seconds.hpp"
#include "worker/camera/synchronise_pair.hpp"
#include "worker/camera/view_details.hpp"
#include "worker/features/match_sparse_stereo.hpp"
#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/pipeline/motion_between_exposures.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kDuration_s = 0.5;
constexpr int kMaxSteps = 15;
constexpr double kRestTime_s = 2.0;
constexpr int kNumFeatures = 300;
constexpr double kTolerance_px = 4.0;  // ranges are not right yet
constexpr std::uint64_t kSeed = 24;

// Returns the number of frames in a duration, at least 1.
int frames_in(const types::Recording& recording, double seconds) {
    const auto first = recording.frame(0);
    const auto last = recording.frame(recording.num_frames() - 1);
    if (!first || !last) return 1;
    const double duration_s = base::to_s(last->timestamp_ns - first->timestamp_ns);
    const double rate = (recording.num_frames() - 1) / std::max(1e-3, duration_s);
    return std::max(1, static_cast<int>(std::lround(seconds * rate)));
}

// Returns whether the view is the same `num_frames` later, or earlier at the end; false if the
// recording is shorter. Light that plays over a scene at rest drags features along by centimetres,
// but to and fro.
bool rests(const types::Recording& recording, const types::StereoFrame& frame, int num_frames) {
    const bool is_at_end = frame.index + num_frames >= recording.num_frames();
    const int other_index = is_at_end ? frame.index - num_frames : frame.index + num_frames;
    if (other_index < 0) return false;
    const auto other = recording.frame(other_index);
    return other && camera::is_same_view(camera::view_details(camera::small_view(frame.left)),
                                         camera::view_details(camera::small_view(other->left)));
}

// The features of a window, tracked from frame to frame.
class WindowFeatures {
public:
    explicit WindowFeatures(const types::RectifiedRig& rig)
        : rig_(rig), num_disparities_px_(rig.width_px / 3), tracker_(rig, kNumFeatures) {}

    // `between`: of a pair whose images were not exposed together, as far as it is known.
    void start(const types::RectifiedFrame& recorded,
               const std::optional<types::ExposureMotion>& between) {
        const types::RectifiedFrame frame = camera::synchronise_pair(recorded, between);
        tracker_.track(frame.left, {}, Eigen::Isometry3d::Identity());
        odometry::add_new_features(rig_, frame, {}, num_disparities_px_, tracker_, features_);
        first_ = features_;
    }

    // Returns false if too few features agree on a motion. `share` of the last step's motion lies
    // between the exposures.
    bool step(const types::RectifiedFrame& recorded, double share) {
        const types::RectifiedFrame frame = camera::synchronise_pair(recorded, moved_by(share));
        const types::Features previous = std::move(features_);
        features_ = tracker_.track(frame.left, previous, motion_);
        features::match_sparse_stereo(frame, {}, num_disparities_px_, features_);
        const odometry::Registration motion = registered(previous);
        motion_ = motion.T_current_previous;
        return motion.found;
    }

    // Returns a share of the last step's motion; nullopt if it is none.
    std::optional<types::ExposureMotion> moved_by(double share) const {
        return motion_between_exposures(rig_, motion_, share, features_);
    }

    calibration::RangeWindow window() const {
        calibration::RangeWindow result;
        const odometry::Registration motion = registered(first_);
        if (!motion.found) return result;
        result.T_after_before = motion.T_current_previous;
        for (const odometry::PointPair& pair : motion.inliers)
            result.matches.push_back({pair.previous_px, pair.current_px});
        return result;
    }

private:
    odometry::Registration registered(const types::Features& earlier) const {
        return odometry::register_points(
            rig_,
            odometry::with_depth_at_both_times(rig_, earlier, features_),
            kTolerance_px,
            kSeed);
    }

    types::RectifiedRig rig_;
    int num_disparities_px_;
    features::FeatureTracker tracker_;
    types::Features first_;
    types::Features features_;
    Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity();  // of the last step
};

calibration::RangeWindow track_range_window(const types::Recording& recording,
                                            const camera::Rectifier& rectifier,
                                            int first_frame,
                                            int num_steps,
                                            int num_apart) {
    WindowFeatures features(rectifier.rig());
    std::int64_t before_ns = 0;
    for (int i = 0; i <= num_steps; ++i) {
        const auto frame = recording.frame(first_frame + i);
        if (!frame || (i == 0 && rests(recording, *frame, num_apart))) return {};
        const types::RectifiedFrame rectified = rectifier.rectify(*frame);
        const double interval_s = base::to_s(frame->timestamp_ns - before_ns);
        if (i == 0)
            features.start(rectified, exposure_motion_at(recording, rectifier, *frame));
        else if (!features.step(rectified, frame->right_delay_s / interval_s))
            return {};
        before_ns = frame->timestamp_ns;
    }
    return features.window();
}

}  // namespace

std::optional<types::ExposureMotion> exposure_motion_at(const types::Recording& recording,
                                                        const camera::Rectifier& rectifier,
                                                        const types::StereoFrame& frame) {
    if (frame.right_delay_s == 0.0 || frame.index + 1 >= recording.num_frames())
        return std::nullopt;
    const auto next = recording.frame(frame.index + 1);
    if (!next) return std::nullopt;
    WindowFeatures features(rectifier.rig());
    features.start(rectifier.rectify(frame), std::nullopt);
    if (!features.step(rectifier.rectify(*next), 0.0)) return std::nullopt;
    const double interval_s = base::to_s(next->timestamp_ns - frame.timestamp_ns);
    return features.moved_by(frame.right_delay_s / interval_s);
}

std::vector<calibration::RangeWindow> track_windows(const types::Recording& recording,
                                                    const camera::Rectifier& rectifier,
                                                    const std::vector<int>& first_frames,
                                                    int end_frame,
                                                    int num_threads) {
    const int num_steps = std::min(kMaxSteps, frames_in(recording, kDuration_s));
    const int num_apart = frames_in(recording, kRestTime_s);
    std::vector<calibration::RangeWindow> windows(first_frames.size());
    base::for_each_index(num_threads, windows.size(), [&](std::size_t i) {
        if (first_frames[i] + num_steps < end_frame)
            windows[i] =
                track_range_window(recording, rectifier, first_frames[i], num_steps, num_apart);
    });
    return windows;
}

}  // namespace divemesh::pipeline
