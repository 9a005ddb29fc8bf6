#include "worker/pipeline/reconstruction_metrics.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {

void run_evaluate(Reconstruction& made, const base::ProgressCallback&) {
    made.evaluation = compare_with_truth(made);
}

}  // namespace divemesh::pipeline
