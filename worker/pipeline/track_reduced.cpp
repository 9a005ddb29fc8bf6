#include "worker/pipeline/track_reduced.hpp"

#include <algorithm>

#include "worker/keyframes/keyframe_store.hpp"
#include "worker/pipeline/estimators.hpp"
#include "worker/pipeline/reconstruct.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kMaxReduction = 4;   // relative to the size at which vision lost the scene
constexpr int kMinWidth_px = 320;  // of reduced images
// Shares of the frames that vision followed.
constexpr double kMaxUnreduced = 0.5;
constexpr double kMinShareToStop = 0.9;
constexpr double kMinGained = 0.25;

double share_by_vision(const types::Track& track) {
    // The first frame has no motion.
    return static_cast<double>(types::num_by_vision(track)) /
           static_cast<double>(std::max<std::ptrdiff_t>(1, std::ssize(track.motions) - 1));
}

// A folder that is removed at the end.
class AttemptFolder {
public:
    explicit AttemptFolder(std::filesystem::path path) : path_(std::move(path)) {}
    AttemptFolder(const AttemptFolder&) = delete;
    AttemptFolder& operator=(const AttemptFolder&) = delete;
    ~AttemptFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

}  // namespace

int reduction_to_width(int width_px, int max_width_px) {
    return max_width_px > 0 ? 1 + (width_px - 1) / max_width_px : 1;
}

int better_reduction(const types::Track& track,
                     const ReconstructionOptions& options,
                     const std::filesystem::path& scratch,
                     AlignedRecording& recording,
                     const base::ProgressCallback& progress) {
    const double unreduced = share_by_vision(track);
    if (!estimator_of(options).tries_reductions || track.motions.size() < 2 ||
        unreduced > kMaxUnreduced)
        return track.reduction;
    const auto all_is_done = [&](Progress at) {
        at.fraction = 1.0;
        progress(at);
    };
    ReconstructionOptions path_only = options;
    path_only.surface = false;
    int best = track.reduction;
    double best_share = unreduced + kMinGained;
    for (int factor = 2; factor <= kMaxReduction && best_share < kMinShareToStop; ++factor) {
        const int reduction = factor * track.reduction;
        if (recording.recorded_rig().cam0.width_px / reduction < kMinWidth_px) break;
        const AttemptFolder folder(scratch);
        recording.set_reduction(reduction);
        recording.rewind();
        const keyframes::KeyframeStore store(folder.path());
        const double share =
            share_by_vision(pipeline::track(recording, path_only, store, all_is_done));
        if (share <= best_share) continue;
        best = reduction;
        best_share = share;
    }
    recording.set_reduction(track.reduction);
    recording.rewind();
    return best;
}

}  // namespace divemesh::pipeline
