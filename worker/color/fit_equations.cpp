#include "worker/color/fit_equations.hpp"

namespace divemesh::color {

FitColumns::FitColumns(const FitModel& model, std::size_t num_knots) {
    for (auto& channel : shared)
        for (std::size_t i = 0; i < ChannelUnknowns::kSize; ++i)
            channel[i] = model.has(i) ? num++ : kNone;
    const int vignetting = num++;
    for (auto& channel : shared) channel.back() = vignetting;
    gains = num;
    num += static_cast<int>(num_knots);
}

void NormalEquations::hold(int column) {
    H.row(column).setZero();
    H.col(column).setZero();
    H(column, column) = 1.0;
    b[column] = 0.0;
}

std::vector<int> columns_at_bounds(const WaterUnknowns& unknowns,
                                   const FitColumns& columns,
                                   const Eigen::VectorXd& b) {
    std::vector<int> held;
    const auto check = [&](int column, double value, const Bounds& bounds) {
        if (column == FitColumns::kNone) return;
        if ((value <= bounds.min && b[column] < 0.0) || (value >= bounds.max && b[column] > 0.0))
            held.push_back(column);
    };
    for (std::size_t c = 0; c < unknowns.channels.size(); ++c)
        for (std::size_t i = 0; i < ChannelUnknowns::kSize; ++i)
            check(columns.shared[c][i], unknowns.channels[c][i], kChannelBounds[i]);
    check(columns.shared[0].back(), unknowns.vignetting, kVignettingBounds);
    return held;
}

void add_step(const FitColumns& columns, const Eigen::VectorXd& step, WaterUnknowns& unknowns) {
    for (std::size_t c = 0; c < unknowns.channels.size(); ++c)
        for (std::size_t i = 0; i < ChannelUnknowns::kSize; ++i)
            if (const int column = columns.shared[c][i]; column != FitColumns::kNone)
                unknowns.channels[c][i] += step[column];
    unknowns.vignetting += step[columns.shared[0].back()];
    for (std::size_t i = 0; i < unknowns.log_gains.size(); ++i)
        unknowns.log_gains[i] += step[columns.gains + static_cast<Eigen::Index>(i)];
    clamp(unknowns);
}

void PointEquations::add(
    const Prediction& seen, double error, double weight, int gain, double gain_share) {
    Shared by;
    for (std::size_t i = 0; i < ChannelUnknowns::kSize; ++i)
        by[static_cast<Eigen::Index>(i)] = seen.by_channel[i];
    by[ChannelUnknowns::kSize] = seen.by_vignetting;
    squared_ += weight * by * by.transpose();
    with_color_ += weight * seen.by_color * by;
    right_ += weight * error * by;
    color_squared_ += weight * seen.by_color * seen.by_color;
    color_right_ += weight * error * seen.by_color;
    const auto add_gain = [&](Gain& of_gain, double by_gain) {
        of_gain.squared += weight * by_gain * by_gain;
        of_gain.with_color += weight * by_gain * seen.by_color;
        of_gain.right += weight * by_gain * error;
        of_gain.with_shared += weight * by_gain * by;
    };
    const double by_first = (1.0 - gain_share) * seen.value;
    const double by_next = gain_share * seen.value;
    add_gain(gain_in(gain), by_first);
    if (gain_share <= 0.0) return;
    gain_in(gain).with_next += weight * by_first * by_next;
    add_gain(gain_in(gain + 1), by_next);
}

// Columns ascend, and a sighting has two of them at most.
PointEquations::Gain& PointEquations::gain_in(int column) {
    const std::size_t num = gains_.size();
    for (std::size_t back = 1; back <= 2 && back <= num; ++back)
        if (gains_[num - back].column == column) return gains_[num - back];
    return gains_.emplace_back(Gain{.column = column});
}

void PointEquations::bound_color() {
    if (color_right_ > 0.0) return;
    with_color_.setZero();
    for (Gain& gain : gains_) gain.with_color = 0.0;
    color_right_ = 0.0;
    color_squared_ = 1.0;
}

double PointEquations::right_of(const Gain& gain) const {
    return gain.right - gain.with_color * color_right_ / color_squared_;
}

double PointEquations::right_of(int shared) const {
    return right_[shared] - with_color_[shared] * color_right_ / color_squared_;
}

void PointEquations::add_to(NormalEquations& equations,
                            const std::array<int, FitColumns::kShared>& columns) const {
    if (color_squared_ <= 0.0) return;
    for (int i = 0; i < FitColumns::kShared; ++i) {
        const int row = columns[static_cast<std::size_t>(i)];
        if (row == FitColumns::kNone) continue;
        equations.b[row] += right_of(i);
        for (int j = 0; j < FitColumns::kShared; ++j)
            if (const int column = columns[static_cast<std::size_t>(j)];
                column != FitColumns::kNone)
                equations.H(row, column) +=
                    squared_(i, j) - with_color_[i] * with_color_[j] / color_squared_;
        for (const Gain& gain : gains_) {
            const double cross =
                gain.with_shared[i] - with_color_[i] * gain.with_color / color_squared_;
            equations.H(row, gain.column) += cross;
            equations.H(gain.column, row) += cross;
        }
    }
    for (const Gain& gain : gains_) {
        equations.b[gain.column] += right_of(gain);
        equations.H(gain.column, gain.column) += gain.squared;
        if (gain.with_next > 0.0) {
            equations.H(gain.column, gain.column + 1) += gain.with_next;
            equations.H(gain.column + 1, gain.column) += gain.with_next;
        }
        for (const Gain& other : gains_)
            equations.H(gain.column, other.column) -=
                gain.with_color * other.with_color / color_squared_;
    }
}

void PointEquations::add_projected(const Eigen::MatrixXd& rows,
                                   const std::array<int, FitColumns::kShared>& columns,
                                   double scale,
                                   Eigen::VectorXd& sum) const {
    if (color_squared_ <= 0.0) return;
    for (int i = 0; i < FitColumns::kShared; ++i)
        if (const int row = columns[static_cast<std::size_t>(i)]; row != FitColumns::kNone)
            sum += rows.col(row) * (scale * right_of(i));
    for (const Gain& gain : gains_) sum += rows.col(gain.column) * (scale * right_of(gain));
}

}  // namespace divemesh::color
