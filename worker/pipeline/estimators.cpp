#include "worker/pipeline/estimators.hpp"

#include "worker/pipeline/pairwise_tracker.hpp"
#include "worker/pipeline/window_tracker.hpp"

namespace divemesh::pipeline {

const Estimator& estimator_of(const ReconstructionOptions& options) {
    static constexpr Estimator kPairwise{track_pairwise, false, false};
    static constexpr Estimator kWindow{track_window, true, true};
    return options.estimator == "pairwise" ? kPairwise : kWindow;
}

}  // namespace divemesh::pipeline
