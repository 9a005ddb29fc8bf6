#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "worker/color/water_unknowns.hpp"

namespace divemesh::color {

// The columns of the unknowns in the equations; kNone for what the model does not have.
struct FitColumns {
    static constexpr int kNone = -1;
    // Number of columns that one sighting has besides that of its gain: its channel, vignetting.
    static constexpr int kShared = ChannelUnknowns::kSize + 1;

    std::array<std::array<int, kShared>, 3> shared = {};  // of each channel
    int gains = 0;                                        // of the first knot
    int num = 0;

    FitColumns(const FitModel& model, std::size_t num_knots);
};

// The normal equations H x = b of a Gauss-Newton step.
struct NormalEquations {
    Eigen::MatrixXd H;
    Eigen::VectorXd b;

    explicit NormalEquations(int size)
        : H(Eigen::MatrixXd::Zero(size, size)), b(Eigen::VectorXd::Zero(size)) {}

    // Leaves an unknown as it is: its step is 0.
    void hold(int column);
};

// Returns the columns of the unknowns at a bound that the step would move beyond it, by the
// gradient `b`.
std::vector<int> columns_at_bounds(const WaterUnknowns& unknowns,
                                   const FitColumns& columns,
                                   const Eigen::VectorXd& b);

// Adds a step to the unknowns, within their bounds.
void add_step(const FitColumns& columns, const Eigen::VectorXd& step, WaterUnknowns& unknowns);

// What the sightings of one point tell in one channel. Its own colour is eliminated (Schur
// complement).
class PointEquations {
public:
    // Adds a sighting that is predicted as `seen`, with what it exceeds that by and its weight.
    // `gain_share`: of the gain in the column after `gain`, as GainPlace. Columns must ascend.
    void add(const Prediction& seen, double error, double weight, int gain, double gain_share);
    // Keeps the colour where it is if it would fall: it is 0 already.
    void bound_color();

    void add_to(NormalEquations& equations,
                const std::array<int, FitColumns::kShared>& columns) const;
    // Adds the products of each row of `rows` with the gradient of the point, times `scale`.
    void add_projected(const Eigen::MatrixXd& rows,
                       const std::array<int, FitColumns::kShared>& columns,
                       double scale,
                       Eigen::VectorXd& sum) const;

private:
    using Shared = Eigen::Matrix<double, FitColumns::kShared, 1>;
    struct Gain {
        int column = 0;
        double squared = 0.0;
        double with_next = 0.0;  // with the gain in the next column
        double with_color = 0.0;
        double right = 0.0;
        Shared with_shared = Shared::Zero();
    };

    Gain& gain_in(int column);
    double right_of(const Gain& gain) const;
    double right_of(int shared) const;

    Eigen::Matrix<double, FitColumns::kShared, FitColumns::kShared> squared_ =
        Eigen::Matrix<double, FitColumns::kShared, FitColumns::kShared>::Zero();
    Shared with_color_ = Shared::Zero();
    Shared right_ = Shared::Zero();
    double color_squared_ = 0.0;
    double color_right_ = 0.0;
    std::vector<Gain> gains_;
};

}  // namespace divemesh::color
