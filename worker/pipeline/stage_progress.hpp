#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "worker/base/observer.hpp"

namespace divemesh::pipeline {

// Turns the progress of one stage after the other into the progress of the whole: stage weights,
// frames per second, seconds left.
class StageProgress {
public:
    explicit StageProgress(base::ProgressCallback report) : report_(std::move(report)) {}

    // Ends the stage before; `share` is the part of the whole that this one is expected to take.
    // What is returned goes into the stage; it may throw Error{Cancelled}.
    base::ProgressCallback begin(const std::string& stage, double share);
    // Ends the last stage: everything is done.
    void finish();

private:
    using Clock = std::chrono::steady_clock;
    void end_stage();
    void forward(Progress progress);

    base::ProgressCallback report_;
    std::string stage_;
    double share_begun_ = 0.0;
    double share_ = 0.0;
    Clock::time_point started_ = Clock::now();
    Clock::time_point stage_started_ = started_;
};

}  // namespace divemesh::pipeline
