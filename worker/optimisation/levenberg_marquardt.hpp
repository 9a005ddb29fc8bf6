#pragma once

#include "worker/optimisation/factor_graph.hpp"

namespace divemesh::optimisation {

// Moves the unknowns of a graph to where its cost is least near by (Levenberg and Marquardt, the
// damping as in Nielsen, "Damping parameter in Marquardt's method", 1999), landmarks eliminated,
// the rest dense. Ends when a step lowers the cost by less than `tolerance` of it. One thread: the
// same input gives the same bits.
void levenberg_marquardt(FactorGraph& graph, int max_iterations, double tolerance);

}  // namespace divemesh::optimisation
