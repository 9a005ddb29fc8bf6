#pragma once

#include "worker/optimisation/factor_graph.hpp"

namespace divemesh::optimisation {

// Moves the unknowns of a graph to the nearest local min of the cost (Levenberg and Marquardt, the
// damping as in Nielsen, "Damping parameter in Marquardt's method", 1999). Landmarks are
// eliminated, the rest is dense. Ends when a step reduces the cost by less than the fraction
// `tolerance`. Single-threaded: the same input gives the same bits.
void levenberg_marquardt(FactorGraph& graph, int max_iterations, double tolerance);

}  // namespace divemesh::optimisation
