#pragma once

#include <ceres/iteration_callback.h>
#include <exception>

#include "worker/base/observer.hpp"

namespace divemesh::optimisation {

// The callback that reports progress and allows cancellation during a long solve. An exception is
// stored until the solver has stopped, as it must not pass through Ceres.
class SolverProgress : public ceres::IterationCallback {
public:
    SolverProgress(const base::ProgressCallback& report, Progress progress)
        : report_(report), progress_(std::move(progress)) {}

    ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
        try {
            report_(progress_);
        } catch (...) {
            failure_ = std::current_exception();
            return ceres::SOLVER_ABORT;
        }
        return ceres::SOLVER_CONTINUE;
    }

    // Throws the stored exception, if any.
    void rethrow() const {
        if (failure_) std::rethrow_exception(failure_);
    }

private:
    const base::ProgressCallback& report_;
    Progress progress_;
    std::exception_ptr failure_;
};

}  // namespace divemesh::optimisation
