#include "worker/optimisation/reduced_information.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <ceres/crs_matrix.h>
#include <cmath>
#include <optional>
#include <utility>

#include "worker/optimisation/noise_scale.hpp"

namespace divemesh::optimisation {
namespace {

constexpr int kLandmarkSize = 3;
constexpr int kRows = 3;                         // of a camera's residual
constexpr std::size_t kMaxTriplets = 4'000'000;  // before they are summed up

// The sum of entries of a symmetric matrix, lower triangle.
class Accumulator {
public:
    explicit Accumulator(int size) : sum_(size, size) {}

    void add(int row, int column, double value) {
        if (row < column) return;
        triplets_.emplace_back(row, column, value);
        if (triplets_.size() >= kMaxTriplets) flush();
    }
    const Eigen::SparseMatrix<double>& sum() {
        flush();
        return sum_;
    }

private:
    void flush() {
        Eigen::SparseMatrix<double> part(sum_.rows(), sum_.cols());
        part.setFromTriplets(triplets_.begin(), triplets_.end());
        sum_ = Eigen::SparseMatrix<double>(sum_ + part);
        triplets_.clear();
    }

    Eigen::SparseMatrix<double> sum_;
    std::vector<Eigen::Triplet<double>> triplets_;
};

// A few rows of the Jacobian, dense over the columns they use.
struct Rows {
    std::vector<int> columns;  // ascending
    Eigen::MatrixXd J;
};

Rows dense_rows(const ceres::CRSMatrix& jacobian, const std::vector<int>& rows) {
    Rows result;
    for (const int row : rows)
        for (auto i = static_cast<std::size_t>(jacobian.rows[static_cast<std::size_t>(row)]);
             i < static_cast<std::size_t>(jacobian.rows[static_cast<std::size_t>(row) + 1]);
             ++i)
            result.columns.push_back(jacobian.cols[i]);
    std::sort(result.columns.begin(), result.columns.end());
    result.columns.erase(std::unique(result.columns.begin(), result.columns.end()),
                         result.columns.end());
    result.J = Eigen::MatrixXd::Zero(std::ssize(rows), std::ssize(result.columns));
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const auto row = static_cast<std::size_t>(rows[r]);
        for (auto i = static_cast<std::size_t>(jacobian.rows[row]);
             i < static_cast<std::size_t>(jacobian.rows[row + 1]);
             ++i) {
            const auto at =
                std::lower_bound(result.columns.begin(), result.columns.end(), jacobian.cols[i]);
            result.J(static_cast<int>(r), at - result.columns.begin()) = jacobian.values[i];
        }
    }
    return result;
}

void add(const std::vector<int>& columns, const Eigen::MatrixXd& H, Accumulator& sum) {
    for (int i = 0; i < H.rows(); ++i)
        for (int j = 0; j <= i; ++j)
            sum.add(columns[static_cast<std::size_t>(i)],
                    columns[static_cast<std::size_t>(j)],
                    H(i, j));
}

// Adds the information of one landmark's observations about the other blocks. The landmark has the
// last three columns.
void add_landmark(Rows rows, Accumulator& sum) {
    const auto num_kept = static_cast<int>(std::ssize(rows.columns)) - kLandmarkSize;
    const Eigen::MatrixXd C = rows.J.leftCols(num_kept);
    const Eigen::MatrixXd A = rows.J.rightCols(kLandmarkSize);
    const Eigen::Matrix3d own = A.transpose() * A;
    const Eigen::LDLT<Eigen::Matrix3d> factor(own);
    if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() <= 0.0) return;
    const Eigen::MatrixXd cross = A.transpose() * C;
    rows.columns.resize(static_cast<std::size_t>(num_kept));
    add(rows.columns, C.transpose() * C - cross.transpose() * factor.solve(cross), sum);
}

// A solved problem, linearised at its solution, without its losses.
struct Linearised {
    std::vector<int> start;      // of each kept block; -1: constant
    int num_kept = 0;            // columns; those of the landmarks come after
    int first_observed_row = 0;  // all rows from here on are observations
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;

    // Returns the landmark of a row; -1: it has none.
    int landmark_of(int row) const {
        const int end = jacobian.rows[static_cast<std::size_t>(row) + 1];
        if (end == jacobian.rows[static_cast<std::size_t>(row)]) return -1;
        const int last = jacobian.cols[static_cast<std::size_t>(end) - 1];
        return last < num_kept ? -1 : (last - num_kept) / kLandmarkSize;
    }
    Eigen::Vector3d residual(int first_row) const {
        return Eigen::Map<const Eigen::Vector3d>(residuals.data() + first_row);
    }
    // Returns 3, or 2 without disparity.
    int num_measured(int first_row) const {
        return landmark_of(first_row + 2) >= 0 && residual(first_row).z() != 0.0 ? 3 : 2;
    }
    bool is_outlier(int first_row) const {
        return residual(first_row).norm() >
               kOutlierSigmas * std::sqrt(static_cast<double>(num_measured(first_row)));
    }
};

Linearised linearise(ceres::Problem& problem,
                     const std::vector<double*>& kept,
                     const std::vector<double*>& landmarks) {
    Linearised result;
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;
    for (double* block : kept) {
        const bool constant = problem.IsParameterBlockConstant(block);
        result.start.push_back(constant ? -1 : result.num_kept);
        if (constant) continue;
        result.num_kept += problem.ParameterBlockTangentSize(block);
        options.parameter_blocks.push_back(block);
    }
    options.parameter_blocks.insert(
        options.parameter_blocks.end(), landmarks.begin(), landmarks.end());
    problem.GetResidualBlocks(&options.residual_blocks);
    problem.Evaluate(options, nullptr, &result.residuals, nullptr, &result.jacobian);
    while (result.first_observed_row < result.jacobian.num_rows &&
           result.landmark_of(result.first_observed_row) < 0)
        ++result.first_observed_row;
    return result;
}

// Calls `landmark` for each landmark with the first rows of its observations. All other rows are
// added to `others`.
template <typename OfLandmark>
void for_each_landmark(const Linearised& all, Accumulator& others, const OfLandmark& landmark) {
    for (int row = 0; row < all.jacobian.num_rows;) {
        const int index = all.landmark_of(row);
        if (index < 0) {
            const Rows rows = dense_rows(all.jacobian, {row});
            add(rows.columns, rows.J.transpose() * rows.J, others);
            ++row;
            continue;
        }
        std::vector<int> observations;
        for (; row < all.jacobian.num_rows && all.landmark_of(row) == index; row += kRows)
            observations.push_back(row);
        landmark(observations);
    }
}

// Returns the measured rows of the observations that are inliers.
std::vector<int> good_rows(const Linearised& all, const std::vector<int>& observations) {
    std::vector<int> rows;
    for (const int first : observations)
        for (int i = 0; i < all.num_measured(first) && !all.is_outlier(first); ++i)
            rows.push_back(first + i);
    return rows;
}

// A landmark's observations with the landmark eliminated: information and gradient of the other
// blocks, each residual with Huber's weight.
struct Score {
    std::vector<int> columns;
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
    Eigen::MatrixXd B;  // of the shared errors
    Eigen::MatrixXd H_shared;
    Eigen::VectorXd g_shared;
    double num_free = 0.0;  // number of rows minus the landmark's unknowns
    double weights = 0.0;   // sum of Huber's weights over the rows
    double slopes = 0.0;    // sum of the derivatives of Huber's psi over the rows
};

// Returns the rows of the shared errors for observations' rows.
Eigen::MatrixXd shared_rows(const Linearised& all,
                            const std::vector<int>& rows,
                            const SharedJacobian& shared) {
    Eigen::MatrixXd result(std::ssize(rows), shared.num_columns);
    if (shared.num_columns == 0) return result;
    Eigen::Matrix3Xd of_observation;
    int last = -1;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const int observation = (rows[i] - all.first_observed_row) / kRows;
        if (observation != last)
            of_observation = shared.of_observation(static_cast<std::size_t>(observation));
        last = observation;
        result.row(static_cast<Eigen::Index>(i)) =
            of_observation.row((rows[i] - all.first_observed_row) % kRows);
    }
    return result;
}

std::optional<Score> score_of(const Linearised& all,
                              const std::vector<int>& observations,
                              double huber,
                              const SharedJacobian& shared) {
    const std::vector<int> good = good_rows(all, observations);
    if (good.size() <= kLandmarkSize) return std::nullopt;
    Rows rows = dense_rows(all.jacobian, good);
    Eigen::MatrixXd J_shared = shared_rows(all, good, shared);
    Eigen::VectorXd r(std::ssize(good));
    double weights = 0.0;
    double slopes = 0.0;
    for (std::size_t i = 0; i < good.size(); ++i) {
        const int first =
            *(std::upper_bound(observations.begin(), observations.end(), good[i]) - 1);
        const double norm = all.residual(first).norm();
        const double weight = std::min(1.0, huber / norm);
        const double root = std::sqrt(weight);
        const double across = 1.0 - 1.0 / all.num_measured(first);
        weights += weight;
        slopes += norm > huber ? weight * across : 1.0;
        const auto row = static_cast<Eigen::Index>(i);
        r[row] = root * all.residuals[static_cast<std::size_t>(good[i])];
        rows.J.row(row) *= root;
        J_shared.row(row) *= root;
    }
    const auto num_kept = static_cast<int>(std::ssize(rows.columns)) - kLandmarkSize;
    const auto A = rows.J.rightCols(kLandmarkSize);
    const Eigen::Matrix3d own = A.transpose() * A;
    const Eigen::LDLT<Eigen::Matrix3d> factor(own);
    if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() <= 0.0) return std::nullopt;
    const Eigen::MatrixXd C = rows.J.leftCols(num_kept);
    const Eigen::MatrixXd rest = C - A * factor.solve(A.transpose() * C);
    J_shared -= A * factor.solve(A.transpose() * J_shared);
    rows.columns.resize(static_cast<std::size_t>(num_kept));
    // Fitting the landmark makes its residuals too small; this corrects for it.
    const auto num_free = static_cast<double>(good.size() - kLandmarkSize);
    r *= std::sqrt(static_cast<double>(good.size()) / num_free);
    return Score{rows.columns,
                 rest.transpose() * rest,
                 rest.transpose() * r,
                 rest.transpose() * J_shared,
                 J_shared.transpose() * J_shared,
                 J_shared.transpose() * r,
                 num_free,
                 weights,
                 slopes};
}

// Adds J x to `sum`, row by row, for the rows that are not the cameras'.
void add_product(const ceres::CRSMatrix& J, const Eigen::VectorXd& x, Eigen::VectorXd& sum) {
    for (Eigen::Index row = 0; row < sum.size(); ++row)
        for (auto i = static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row)]);
             i < static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row) + 1]);
             ++i)
            sum[row] += J.values[i] * x[J.cols[i]];
}

// Returns what a shift of the sensors' clock does to the rows that are not the cameras'.
Eigen::VectorXd rows_by_time(ceres::Problem& problem,
                             const Linearised& all,
                             const SharedJacobian& shared) {
    Eigen::VectorXd result = Eigen::VectorXd::Zero(all.first_observed_row);
    add_product(all.jacobian, shared.by_time, result);
    for (const SharedJacobian::Constant& constant : shared.constants) {
        ceres::Problem::EvaluateOptions options;
        options.apply_loss_function = false;
        options.parameter_blocks = {constant.block};
        problem.GetResidualBlocks(&options.residual_blocks);
        ceres::CRSMatrix jacobian;
        problem.SetParameterBlockVariable(constant.block);
        problem.Evaluate(options, nullptr, nullptr, nullptr, &jacobian);
        problem.SetParameterBlockConstant(constant.block);
        add_product(jacobian, constant.by_time, result);
    }
    return result;
}

// Returns the derivative of the rows that are not the cameras' with respect to the shared errors of
// the sensors.
Eigen::MatrixXd sensor_rows(ceres::Problem& problem,
                            const Linearised& all,
                            const SharedJacobian& shared) {
    const int num_columns = shared.num_sensor_columns();
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(all.first_observed_row, num_columns);
    if (shared.by_time.size() > 0) result.col(0) = rows_by_time(problem, all, shared);
    const ceres::CRSMatrix& J = all.jacobian;
    for (const SharedJacobian::OfRates& of : shared.of_rates)
        for (int row = of.first_row; row < of.first_row + of.num_rows; ++row)
            for (auto i = static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row)]);
                 i < static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row) + 1]);
                 ++i) {
                const int axis = J.cols[i] - of.bias_column;
                if (axis < 0 || axis > 2) continue;
                result(row, num_columns - 3 + axis) = J.values[i] * of.rate[axis];
            }
    return result;
}

// Adds J^T `rows` to the last columns of B; the rows are the first ones of J.
void add_projection(const ceres::CRSMatrix& J, const Eigen::MatrixXd& rows, Eigen::MatrixXd& B) {
    for (Eigen::Index row = 0; row < rows.rows(); ++row)
        for (auto i = static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row)]);
             i < static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row) + 1]);
             ++i)
            B.row(J.cols[i]).tail(rows.cols()) += J.values[i] * rows.row(row);
}

}  // namespace

ReducedInformation reduced_information(ceres::Problem& problem,
                                       const std::vector<double*>& kept,
                                       const std::vector<double*>& landmarks,
                                       double huber) {
    const Linearised all = linearise(problem, kept, landmarks);
    Accumulator cameras(all.num_kept);
    Accumulator others(all.num_kept);
    NoiseScale noise(huber);
    int num_landmarks = 0;
    for_each_landmark(all, others, [&](const std::vector<int>& observations) {
        for (std::size_t i = 0; i < observations.size(); ++i) {
            const Eigen::Vector3d before =
                i > 0 ? all.residual(observations[i - 1]) : Eigen::Vector3d::Zero();
            noise.add(all.residual(observations[i]),
                      i > 0 ? &before : nullptr,
                      all.num_measured(observations[i]));
        }
        ++num_landmarks;
        noise.end_landmark();
        const std::vector<int> good = good_rows(all, observations);
        if (good.size() > kLandmarkSize) add_landmark(dense_rows(all.jacobian, good), cameras);
    });
    ReducedInformation result;
    result.start = all.start;
    result.noise_scale = noise.scale(kLandmarkSize * num_landmarks + all.num_kept);
    result.lower = cameras.sum() / (result.noise_scale * result.noise_scale) + others.sum();
    return result;
}

ClusteredInformation clustered_information(ceres::Problem& problem,
                                           const std::vector<double*>& kept,
                                           const std::vector<double*>& landmarks,
                                           double huber,
                                           const SharedJacobian& shared) {
    const Linearised all = linearise(problem, kept, landmarks);
    Accumulator cameras(all.num_kept);
    Accumulator scores(all.num_kept);
    Accumulator others(all.num_kept);
    Eigen::MatrixXd B =
        Eigen::MatrixXd::Zero(all.num_kept, shared.num_columns + shared.num_sensor_columns());
    SharedScores of_shared(all.num_kept, shared.num_columns);
    std::vector<bool> seen(static_cast<std::size_t>(all.num_kept), false);
    double num_landmarks = 0.0;
    double num_free = 0.0;
    double weights = 0.0;
    double slopes = 0.0;
    for_each_landmark(all, others, [&](const std::vector<int>& observations) {
        const auto score = score_of(all, observations, huber, shared);
        if (!score) return;
        add(score->columns, score->H, cameras);
        add(score->columns, score->g * score->g.transpose(), scores);
        for (std::size_t i = 0; i < score->columns.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            B.row(score->columns[i]).head(shared.num_columns) += score->B.row(row);
            of_shared.covariance.row(score->columns[i]) +=
                score->g[row] * score->g_shared.transpose();
        }
        of_shared.information += score->H_shared;
        of_shared.sum += score->g_shared;
        of_shared.variances += score->g_shared.cwiseAbs2();
        for (const int column : score->columns) seen[static_cast<std::size_t>(column)] = true;
        num_free += score->num_free;
        weights += score->weights;
        slopes += score->slopes;
        ++num_landmarks;
    });
    // The scores change with the states by the slope of psi, which is less than the weights.
    const double slope = weights > 0.0 ? slopes / weights : 1.0;
    B *= slope;
    of_shared.information *= slope;
    if (shared.num_sensor_columns() > 0)
        add_projection(all.jacobian, sensor_rows(problem, all, shared), B);
    // The same correction for what is fitted to all landmarks.
    const auto num_fitted = static_cast<double>(std::count(seen.begin(), seen.end(), true));
    const double few = num_landmarks / std::max(1.0, num_landmarks - 1.0) * num_free /
                       std::max(1.0, num_free - num_fitted);
    of_shared.variances *= few;
    of_shared.covariance *= few;
    return {slope * cameras.sum() + others.sum(),
            few * scores.sum() + others.sum(),
            std::move(B),
            std::move(of_shared),
            all.start};
}

}  // namespace divemesh::optimisation
