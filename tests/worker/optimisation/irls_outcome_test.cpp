#include "worker/optimisation/irls_outcome.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace divemesh::optimisation {
namespace {

using Termination = types::SolverOutcome::Termination;

TEST(IrlsOutcomeTest, ASmallLastStepIsConvergence) {
    const types::SolverOutcome outcome = outcome_of(
        {.num_steps = 12, .initial_cost = 9.0, .final_cost = 4.0, .last_step_sigmas = 0.01});
    EXPECT_EQ(outcome.termination, Termination::Converged);
    EXPECT_EQ(outcome.num_iterations, 12);
    EXPECT_EQ(outcome.initial_cost, 9.0);
    EXPECT_EQ(outcome.final_cost, 4.0);
}

TEST(IrlsOutcomeTest, OnlyALastStepAboveTheNoiseIsStillMoving) {
    const types::SolverOutcome within = outcome_of(
        {.num_steps = 12, .initial_cost = 9.0, .final_cost = 4.0, .last_step_sigmas = 0.5});
    const types::SolverOutcome above = outcome_of(
        {.num_steps = 12, .initial_cost = 9.0, .final_cost = 4.0, .last_step_sigmas = 2.0});
    EXPECT_TRUE(within.stopped_early());
    EXPECT_FALSE(within.still_moving());
    EXPECT_TRUE(above.still_moving());
}

TEST(IrlsOutcomeTest, RoundingIsNoFailure) {
    EXPECT_FALSE(outcome_of({.initial_cost = 4.0, .final_cost = 4.0 + 1e-9}).failed());
}

TEST(IrlsOutcomeTest, GrowingOrInfiniteErrorsAreAFailure) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(outcome_of({.initial_cost = 4.0, .final_cost = 9.0}).failed());
    EXPECT_TRUE(outcome_of({.initial_cost = 4.0, .final_cost = kNan}).failed());
    EXPECT_TRUE(
        outcome_of({.initial_cost = 4.0, .final_cost = 3.0, .last_step_sigmas = kNan}).failed());
}

}  // namespace
}  // namespace divemesh::optimisation
