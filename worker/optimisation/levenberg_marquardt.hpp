#pragma once

#include "worker/optimisation/factor_graph.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::optimisation {

// Moves the unknowns of a graph to where its cost is least near by (Levenberg and Marquardt, the
// damping as in Nielsen, "Damping parameter in Marquardt's method", 1999), landmarks eliminated,
// the rest dense. Ends when a step lowers the cost by less than `tolerance` of it. Returns how it
// ended; the unknowns are where the cost was lowest. One thread: the same input gives the same
// bits.
types::SolverOutcome levenberg_marquardt(FactorGraph& graph, int max_iterations, double tolerance);

}  // namespace divemesh::optimisation
