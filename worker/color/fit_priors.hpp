#pragma once

#include "worker/color/fit_equations.hpp"

namespace divemesh::color {

// Adds what is known before any sighting: normal distributions of single unknowns and of
// the differences of two. Few unknowns are so badly seen that this matters: gain against the
// brightness of all, veil against its coefficient in short ranges, and a channel without light.
// Refers to what it is made of.
class FitPriors {
public:
    FitPriors(const FitModel& model, const FitColumns& columns, const WaterUnknowns& unknowns)
        : model_(model), columns_(columns), unknowns_(unknowns) {}

    double loss() const;
    void add_to(NormalEquations& equations) const;

private:
    template <typename Visit>
    void for_each(const Visit& visit) const;

    const FitModel& model_;
    const FitColumns& columns_;
    const WaterUnknowns& unknowns_;
};

}  // namespace divemesh::color
