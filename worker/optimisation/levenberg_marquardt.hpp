#pragma once

#include "worker/optimisation/factor_graph.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::optimisation {

// Moves the unknowns of a graph to the nearest local min of the cost (Levenberg and Marquardt, the
// damping as in Nielsen, "Damping parameter in Marquardt's method", 1999). Landmarks are
// eliminated, the rest is dense. Ends when a step reduces the cost by less than the fraction
// `tolerance`. Returns how it ended; the unknowns have the values with the lowest cost found.
// Single-threaded: the same input gives the same bits.
types::SolverOutcome levenberg_marquardt(FactorGraph& graph, int max_iterations, double tolerance);

}  // namespace divemesh::optimisation
