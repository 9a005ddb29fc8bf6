#include "worker/pipeline/stage_progress.hpp"

#include <algorithm>

namespace divemesh::pipeline {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

base::ProgressCallback StageProgress::begin(const std::string& stage, double share) {
    end_stage();
    stage_ = stage;
    share_ = share;
    stage_started_ = Clock::now();
    forward({});
    return [this](const Progress& progress) { forward(progress); };
}

void StageProgress::finish() {
    share_begun_ = 1.0;
    share_ = 0.0;
    forward({});
}

void StageProgress::end_stage() { share_begun_ = std::min(1.0, share_begun_ + share_); }

void StageProgress::forward(Progress progress) {
    progress.stage = stage_;
    const double stage_s = seconds_since(stage_started_);
    if (progress.frames_done > 0 && stage_s > 0.0)
        progress.frames_per_s = static_cast<double>(progress.frames_done) / stage_s;
    const double fraction = share_begun_ + share_ * std::clamp(progress.fraction, 0.0, 1.0);
    reached_ = std::min(1.0, std::max(reached_, fraction));  // rounded sums of shares may go back
    progress.fraction = reached_;
    if (progress.fraction > 0.02)
        progress.seconds_left =
            seconds_since(started_) * (1.0 - progress.fraction) / progress.fraction;
    report_(progress);
}

}  // namespace divemesh::pipeline
