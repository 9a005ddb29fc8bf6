#include "worker/pipeline/reconstruction_metrics.hpp"
#include "worker/pipeline/scale_of_result.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {

void run_evaluate(Reconstruction& made, const base::ProgressCallback&) {
    made.evaluation = compare_with_truth(made);
    // The known distances may contradict the scale, which is then in their own intervals too.
    if (cover_contradiction(made)) made.evaluation = compare_with_truth(made);
}

}  // namespace divemesh::pipeline
