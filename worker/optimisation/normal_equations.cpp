#include "worker/optimisation/normal_equations.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::optimisation {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kMinDiagonal = 1e-6;  // before damping
// The limit of the determinant of a landmark's H, relative to a sphere's with the same trace.
constexpr double kMinDeterminant = 1e-12;

struct Robust {
    double cost = 0.0;    // rho
    double weight = 1.0;  // d rho / d square
};

Robust robust(const ceres::LossFunction* loss, double square) {
    if (!loss) return {square, 1.0};
    std::array<double, 3> rho{};
    loss->Evaluate(square, rho.data());
    return {rho[0], rho[1]};
}

Eigen::Matrix3d raised(Eigen::Matrix3d H, double damping) {
    H.diagonal() += damping * H.diagonal().cwiseMax(kMinDiagonal);
    return H;
}

// Returns the inverse, 0 if it is not determined.
Eigen::Matrix3d inverse(const Eigen::Matrix3d& H) {
    const double third = H.trace() / 3.0;
    if (!(H.determinant() > kMinDeterminant * third * third * third))
        return Eigen::Matrix3d::Zero();
    return H.inverse();
}

}  // namespace

Columns Columns::of(const FactorGraph& graph, const std::vector<double*>& first) {
    std::vector<bool> measured(graph.blocks().size(), false);
    for (const Factor& factor : graph.factors())
        for (const int block : factor.blocks) measured[static_cast<std::size_t>(block)] = true;
    for (const StereoFactor& seen : graph.observations())
        for (const int block : {seen.rotation, seen.position})
            measured[static_cast<std::size_t>(block)] = true;
    Columns columns;
    columns.start.assign(graph.blocks().size(), -1);
    const auto take = [&](std::size_t index) {
        const Block& block = graph.blocks()[index];
        if (block.fixed || !measured[index] || columns.start[index] >= 0) return;
        columns.start[index] = columns.num;
        columns.num += block.tangent_size();
    };
    for (const double* values : first)
        if (graph.contains(values)) take(static_cast<std::size_t>(graph.index_of(values)));
    for (std::size_t index = 0; index < graph.blocks().size(); ++index) take(index);
    return columns;
}

NormalEquations::NormalEquations(const FactorGraph& graph, Columns columns)
    : graph_(graph), columns_(std::move(columns)) {}

void NormalEquations::linearise() {
    cost_ = 0.0;
    H_.setZero(columns_.num, columns_.num);
    b_.setZero(columns_.num);
    landmarks_.assign(graph_.landmarks().size(), {});
    couplings_.clear();
    for (const Factor& factor : graph_.factors()) add(factor);
    for (const StereoFactor& seen : graph_.observations()) add(seen, landmarks_[seen.landmark]);
}

void NormalEquations::add(const Factor& factor) {
    const int num_rows = factor.cost->num_residuals();
    std::vector<const double*> now;
    std::vector<const double*> at;
    std::vector<RowMajor> jacobians;
    std::vector<double*> outputs;
    int num_columns = 0;
    for (const int index : factor.blocks) {
        now.push_back(block(index).values);
        at.push_back(block(index).linearised_at());
        jacobians.emplace_back(num_rows, block(index).size);
        outputs.push_back(start(index) < 0 ? nullptr : jacobians.back().data());
        if (start(index) >= 0) num_columns += block(index).tangent_size();
    }
    Eigen::VectorXd r(num_rows);
    factor.cost->Evaluate(at.data(), r.data(), outputs.data());
    if (at != now) factor.cost->Evaluate(now.data(), r.data(), nullptr);

    Eigen::MatrixXd J(num_rows, num_columns);
    std::vector<int> columns;
    for (std::size_t i = 0; i < factor.blocks.size(); ++i) {
        const Block& own = block(factor.blocks[i]);
        const int first = start(factor.blocks[i]);
        if (first < 0) continue;
        const auto into = static_cast<Eigen::Index>(columns.size());
        if (own.manifold) {
            RowMajor plus(own.size, own.tangent_size());
            own.manifold->PlusJacobian(at[i], plus.data());
            J.middleCols(into, own.tangent_size()) = jacobians[i] * plus;
        } else {
            J.middleCols(into, own.size) = jacobians[i];
        }
        for (int c = 0; c < own.tangent_size(); ++c) columns.push_back(first + c);
    }
    const Robust loss = robust(factor.loss, r.squaredNorm());
    cost_ += 0.5 * loss.cost;
    H_(columns, columns) += loss.weight * J.transpose() * J;
    b_(columns) += loss.weight * J.transpose() * r;
}

void NormalEquations::add(const StereoFactor& seen, LandmarkTerm& landmark) {
    const Block& rotation = block(seen.rotation);
    const Block& position = block(seen.position);
    const double* point = graph_.landmarks()[seen.landmark]->data();
    Eigen::Vector3d r;
    Eigen::Matrix3d by_point;
    if (!seen.reprojection.linearise(
            rotation.linearised_at(), position.linearised_at(), point, r, by_point))
        return;
    if (rotation.linearised_at() != rotation.values || position.linearised_at() != position.values)
        if (!seen.reprojection(rotation.values, position.values, point, r.data())) return;
    const Robust loss = robust(&graph_.reprojection_loss(), r.squaredNorm());
    cost_ += 0.5 * loss.cost;
    const Eigen::Matrix3d weighted = loss.weight * by_point;
    landmark.H += by_point.transpose() * weighted;
    landmark.b += weighted.transpose() * r;
    if (landmark.last_coupling == 0) landmark.first_coupling = couplings_.size();

    // The tangent of a quaternion is half a rotation vector in world axes. The derivative with
    // respect to the position is the negative of that with respect to the landmark.
    const Eigen::Vector3d from_imu = Eigen::Map<const Eigen::Vector3d>(point) -
                                     Eigen::Map<const Eigen::Vector3d>(position.linearised_at());
    const std::array<int, 2> starts = {start(seen.rotation), start(seen.position)};
    const std::array<Eigen::Matrix3d, 2> J = {2.0 * by_point * base::cross_matrix(from_imu),
                                              -by_point};
    for (std::size_t i = 0; i < 2; ++i) {
        if (starts[i] < 0) continue;
        couplings_.push_back({starts[i], J[i].transpose() * weighted});
        b_.segment<3>(starts[i]) += loss.weight * (J[i].transpose() * r);
        for (std::size_t j = 0; j < 2; ++j)
            if (starts[j] >= 0)
                H_.block<3, 3>(starts[i], starts[j]) += loss.weight * (J[i].transpose() * J[j]);
    }
    landmark.last_coupling = couplings_.size();
}

NormalEquations::Reduced NormalEquations::without_landmarks(double damping) const {
    Reduced result{H_, b_};
    result.H.diagonal() += damping * H_.diagonal().cwiseMax(kMinDiagonal);
    std::vector<Eigen::Matrix3d> gains;
    for (const LandmarkTerm& landmark : landmarks_) {
        const Eigen::Matrix3d H_inverse = inverse(raised(landmark.H, damping));
        gains.clear();
        for (std::size_t i = landmark.first_coupling; i < landmark.last_coupling; ++i) {
            const Coupling& row = couplings_[i];
            gains.push_back(row.W * H_inverse);
            result.b.segment<3>(row.start) -= gains.back() * landmark.b;
            for (std::size_t j = landmark.first_coupling; j <= i; ++j) {
                const Coupling& column = couplings_[j];
                if (row.start >= column.start)
                    result.H.block<3, 3>(row.start, column.start) -=
                        gains.back() * column.W.transpose();
                else
                    result.H.block<3, 3>(column.start, row.start) -=
                        column.W * gains.back().transpose();
            }
        }
    }
    return result;
}

std::optional<NormalEquations::Step> NormalEquations::step(double damping) const {
    const Reduced reduced = without_landmarks(damping);
    const Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower> factor(reduced.H);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
    Step result;
    result.x = -factor.solve(reduced.b);
    if (!result.x.allFinite()) return std::nullopt;
    const auto decrease = [&](const auto& x, const auto& H, const auto& b) {
        return 0.5 * damping * x.cwiseAbs2().dot(H.diagonal().cwiseMax(kMinDiagonal)) -
               0.5 * b.dot(x);
    };
    result.expected_decrease = decrease(result.x, H_, b_);
    for (const LandmarkTerm& landmark : landmarks_) {
        Eigen::Vector3d b = landmark.b;
        for (std::size_t i = landmark.first_coupling; i < landmark.last_coupling; ++i)
            b += couplings_[i].W.transpose() * result.x.segment<3>(couplings_[i].start);
        result.landmarks.emplace_back(-inverse(raised(landmark.H, damping)) * b);
        result.expected_decrease += decrease(result.landmarks.back(), landmark.H, landmark.b);
    }
    return result;
}

std::optional<double> cost_of(const FactorGraph& graph) {
    const auto values = [&](int block) {
        return graph.blocks()[static_cast<std::size_t>(block)].values;
    };
    double sum = 0.0;
    std::vector<const double*> parameters;
    Eigen::VectorXd r;
    for (const Factor& factor : graph.factors()) {
        parameters.clear();
        for (const int block : factor.blocks) parameters.push_back(values(block));
        r.resize(factor.cost->num_residuals());
        if (!factor.cost->Evaluate(parameters.data(), r.data(), nullptr)) return std::nullopt;
        sum += 0.5 * robust(factor.loss, r.squaredNorm()).cost;
    }
    for (const StereoFactor& seen : graph.observations()) {
        Eigen::Vector3d error;
        if (!seen.reprojection(values(seen.rotation),
                               values(seen.position),
                               graph.landmarks()[seen.landmark]->data(),
                               error.data()))
            return std::nullopt;
        sum += 0.5 * robust(&graph.reprojection_loss(), error.squaredNorm()).cost;
    }
    return sum;
}

}  // namespace divemesh::optimisation
