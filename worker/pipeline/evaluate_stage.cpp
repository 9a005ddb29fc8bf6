#include "worker/pipeline/reconstruction_metrics.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::worker {

void run_evaluate(Reconstruction& made, const ProgressCallback&) {
    made.evaluation = compare_with_truth(made);
}

}  // namespace divemesh::worker
