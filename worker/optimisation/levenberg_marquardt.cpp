#include "worker/optimisation/levenberg_marquardt.hpp"

#include <algorithm>
#include <cmath>

#include "worker/optimisation/normal_equations.hpp"

namespace divemesh::optimisation {
namespace {

constexpr double kFirstDamping = 1e-4;
constexpr double kMinDamping = 1e-12;
constexpr double kMaxDamping = 1e12;
constexpr double kMinGain = 1e-3;  // of the expected decrease

// The saved values of all unknowns, to restore after a rejected step.
class Values {
public:
    explicit Values(const FactorGraph& graph) {
        for (const Block& block : graph.blocks())
            if (!block.fixed)
                blocks_.insert(blocks_.end(), block.values, block.values + block.size);
        for (const Eigen::Vector3d* landmark : graph.landmarks()) landmarks_.push_back(*landmark);
    }
    void restore(const FactorGraph& graph) const {
        const double* from = blocks_.data();
        for (const Block& block : graph.blocks()) {
            if (block.fixed) continue;
            std::copy_n(from, block.size, block.values);
            from += block.size;
        }
        for (std::size_t i = 0; i < landmarks_.size(); ++i) *graph.landmarks()[i] = landmarks_[i];
    }

private:
    std::vector<double> blocks_;
    std::vector<Eigen::Vector3d> landmarks_;
};

void move(const FactorGraph& graph, const Columns& columns, const NormalEquations::Step& step) {
    std::vector<double> before;
    for (std::size_t i = 0; i < graph.blocks().size(); ++i) {
        const Block& block = graph.blocks()[i];
        if (columns.start[i] < 0) continue;
        const double* delta = step.x.data() + columns.start[i];
        before.assign(block.values, block.values + block.size);
        if (block.manifold)
            block.manifold->Plus(before.data(), delta, block.values);
        else
            for (int k = 0; k < block.size; ++k) block.values[k] += delta[k];
    }
    for (std::size_t i = 0; i < step.landmarks.size(); ++i)
        *graph.landmarks()[i] += step.landmarks[i];
}

}  // namespace

types::SolverOutcome levenberg_marquardt(FactorGraph& graph, int max_iterations, double tolerance) {
    using Termination = types::SolverOutcome::Termination;
    types::SolverOutcome outcome;
    graph.drop_unseen();
    const Columns columns = Columns::of(graph);
    if (columns.num == 0) {
        outcome.termination = Termination::Converged;
        outcome.message = "there is no unknown";
        return outcome;
    }
    NormalEquations equations(graph, columns);
    equations.linearise();
    outcome.initial_cost = equations.cost();
    outcome.final_cost = equations.cost();
    if (!std::isfinite(outcome.initial_cost)) {
        outcome.message = "the cost is not finite at the start";
        return outcome;
    }
    outcome.termination = Termination::StoppedAtLimit;
    outcome.message = "the cost was still falling after the last iteration";
    double damping = kFirstDamping;
    double growth = 2.0;
    double first_expected = 0.0;
    bool any_taken = false;
    for (int i = 0; i < max_iterations && damping < kMaxDamping; ++i) {
        ++outcome.num_iterations;
        const auto step = equations.step(damping);
        const Values before(graph);
        std::optional<double> cost;
        if (i == 0 && step) first_expected = step->expected_decrease;
        if (step) {
            move(graph, columns, *step);
            cost = cost_of(graph);
        }
        const double decrease = cost ? equations.cost() - *cost : -1.0;
        if (!step || !(decrease >= kMinGain * step->expected_decrease)) {
            before.restore(graph);
            damping *= growth;
            growth *= 2.0;
            continue;
        }
        any_taken = true;
        outcome.final_cost = *cost;
        outcome.last_decrease = decrease / *cost;
        if (decrease <= tolerance * *cost) {
            outcome.termination = Termination::Converged;
            outcome.message = "the last step lowered the cost by next to nothing";
            return outcome;
        }
        const double gain = 2.0 * decrease / step->expected_decrease - 1.0;
        damping = std::max(kMinDamping, damping * std::max(1.0 / 3.0, 1.0 - gain * gain * gain));
        growth = 2.0;
        if (i + 1 < max_iterations) equations.linearise();
    }
    if (!any_taken && first_expected > 0.0 && first_expected <= tolerance * outcome.initial_cost) {
        outcome.termination = Termination::Converged;
        outcome.message = "no step can lower the cost by more than next to nothing";
    } else if (!any_taken || damping >= kMaxDamping) {
        outcome.termination = Termination::Failed;
        outcome.message = "no step lowered the cost";
    }
    return outcome;
}

}  // namespace divemesh::optimisation
