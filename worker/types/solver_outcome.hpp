#pragma once

#include <cstdint>
#include <string>

namespace divemesh::types {

// How a solver ended.
struct SolverOutcome {
    enum class Termination { Converged, StoppedAtLimit, Failed };

    // A solve that stops while its residuals still shrink by half a percent per step, or while a
    // step still moves the unknowns by their standard deviation, has not found its minimum.
    static constexpr double kMaxLastDecrease = 0.01;
    static constexpr double kMaxLastStepSigmas = 1.0;

    Termination termination = Termination::Failed;
    int num_iterations = 0;
    double initial_cost = 0.0;
    double final_cost = 0.0;
    double last_decrease = 0.0;     // by the last accepted step, relative to the cost
    double last_step_sigmas = 0.0;  // last step of the unknowns, RMS of their sigmas; 0: not known
    std::string message;            // for people to read

    bool failed() const { return termination == Termination::Failed; }
    bool converged() const { return termination == Termination::Converged; }
    // Returns true if more iterations would have changed the result.
    bool stopped_early() const { return termination == Termination::StoppedAtLimit; }
    // Returns true if they would have changed it by more than its noise.
    bool still_moving() const {
        return stopped_early() &&
               (last_decrease > kMaxLastDecrease || last_step_sigmas > kMaxLastStepSigmas);
    }
};

// Counts of the outcomes of all solves of one kind.
struct SolverTally {
    std::int64_t num_solves = 0;
    std::int64_t num_converged = 0;
    std::int64_t num_stopped_at_limit = 0;
    std::int64_t num_still_moving = 0;  // of those that stopped
    std::int64_t num_failed = 0;
    std::int64_t num_iterations = 0;
    double initial_cost = 0.0;  // sum over the solves that did not fail, as is final_cost
    double final_cost = 0.0;

    void add(const SolverOutcome& outcome) {
        ++num_solves;
        num_iterations += outcome.num_iterations;
        num_still_moving += outcome.still_moving() ? 1 : 0;
        if (!outcome.failed()) {
            initial_cost += outcome.initial_cost;
            final_cost += outcome.final_cost;
        }
        switch (outcome.termination) {
            case SolverOutcome::Termination::Converged: ++num_converged; break;
            case SolverOutcome::Termination::StoppedAtLimit: ++num_stopped_at_limit; break;
            case SolverOutcome::Termination::Failed: ++num_failed; break;
        }
    }
};

}  // namespace divemesh::types
