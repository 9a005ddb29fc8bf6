#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "worker/base/observer.hpp"

namespace divemesh::pipeline {

// The progress of the whole run, combined from that of its stages: stage weights, frames per
// second, seconds left.
class StageProgress {
public:
    explicit StageProgress(base::ProgressCallback report) : report_(std::move(report)) {}

    // Ends the previous stage and begins the next; `share` is its expected fraction of the whole.
    // Returns the stage's callback, which may throw Error{Cancelled}.
    base::ProgressCallback begin(const std::string& stage, double share);
    // Ends the last stage and reports the run as complete.
    void finish();

private:
    using Clock = std::chrono::steady_clock;
    void end_stage();
    void forward(Progress progress);

    base::ProgressCallback report_;
    std::string stage_;
    double share_begun_ = 0.0;
    double share_ = 0.0;
    double reached_ = 0.0;  // fraction of the whole
    Clock::time_point started_ = Clock::now();
    Clock::time_point stage_started_ = started_;
};

}  // namespace divemesh::pipeline
