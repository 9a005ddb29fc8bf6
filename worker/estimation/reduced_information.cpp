#include "worker/estimation/reduced_information.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <ceres/crs_matrix.h>
#include <cmath>
#include <optional>

namespace divemesh::worker {
namespace {

constexpr int kLandmarkSize = 3;
constexpr int kRows = 3;          // of a camera's residual
constexpr double kOutlier = 5.0;  // sigmas, per row
constexpr double kLeastScale = 1.0;
constexpr double kMostCorrelation = 0.9;
constexpr std::size_t kMostTriplets = 4'000'000;  // before they are summed

// Sums entries of a symmetric matrix, lower triangle.
class Accumulator {
public:
    explicit Accumulator(int size) : sum_(size, size) {}

    void add(int row, int column, double value) {
        if (row < column) return;
        triplets_.emplace_back(row, column, value);
        if (triplets_.size() >= kMostTriplets) flush();
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

// A few rows of the Jacobian, dense over the columns they touch.
struct Rows {
    std::vector<int> columns;  // rising
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

// What the observations of one landmark say about the rest. It has the last three columns.
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

// Mean of |psi|^2 and of div psi per row, for Huber's psi over whole residuals.
class NoiseScale {
public:
    explicit NoiseScale(double huber) : huber_(huber) {}

    // The next observation of a landmark; `before`: the one before it, nullptr: the first.
    void add(const Eigen::Vector3d& r, const Eigen::Vector3d* before, int rows) {
        const double norm = r.norm();
        add(norm, rows);
        if (!before || norm > kOutlier || before->norm() > kOutlier) return;
        products_ += r.dot(*before);
        pair_squares_ += 0.5 * (norm * norm + before->squaredNorm());
        ++num_pairs_;
    }
    void end_landmark() { ++num_landmarks_; }

    double scale(int num_parameters) const {
        const double free = num_rows_ - num_parameters;
        if (free <= 0.0 || divergence_ <= 0.0) return 1.0;
        const double mean_slope = divergence_ / num_rows_;
        return std::max(kLeastScale, std::sqrt(squares_ / free * repetition()) / mean_slope);
    }

private:
    // How many times over neighbouring observations of a landmark say the same thing. What was
    // fitted to n independent ones leaves them with a correlation of -1/n.
    double repetition() const {
        if (num_pairs_ == 0.0 || pair_squares_ <= 0.0) return 1.0;
        const double length = num_pairs_ / num_landmarks_ + 1.0;
        const double correlation =
            std::clamp(products_ / pair_squares_ + 1.0 / length, 0.0, kMostCorrelation);
        return (1.0 + correlation) / (1.0 - correlation);
    }
    void add(double norm, int rows) {
        const double weight = norm > huber_ ? huber_ / norm : 1.0;
        squares_ += weight * weight * norm * norm;
        divergence_ += norm > huber_ ? (rows - 1) * weight : rows;
        num_rows_ += rows;
    }

    double huber_;
    double squares_ = 0.0;
    double divergence_ = 0.0;
    double num_rows_ = 0.0;
    double products_ = 0.0;
    double pair_squares_ = 0.0;
    double num_pairs_ = 0.0;
    double num_landmarks_ = 0.0;
};

int tangent_size(const ceres::Problem& problem, const double* block) {
    return problem.ParameterBlockTangentSize(block);
}

}  // namespace

ReducedInformation reduced_information(ceres::Problem& problem,
                                       const std::vector<double*>& kept,
                                       const std::vector<double*>& landmarks,
                                       double huber) {
    ReducedInformation result;
    ceres::Problem::EvaluateOptions options;
    options.apply_loss_function = false;
    int num_kept = 0;
    for (double* block : kept) {
        const bool constant = problem.IsParameterBlockConstant(block);
        result.start.push_back(constant ? -1 : num_kept);
        if (constant) continue;
        num_kept += tangent_size(problem, block);
        options.parameter_blocks.push_back(block);
    }
    options.parameter_blocks.insert(
        options.parameter_blocks.end(), landmarks.begin(), landmarks.end());
    problem.GetResidualBlocks(&options.residual_blocks);
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;
    problem.Evaluate(options, nullptr, &residuals, nullptr, &jacobian);

    Accumulator cameras(num_kept);
    Accumulator others(num_kept);
    NoiseScale noise(huber);
    const auto landmark_of = [&](int row) {  // -1: none
        const int end = jacobian.rows[static_cast<std::size_t>(row) + 1];
        if (end == jacobian.rows[static_cast<std::size_t>(row)]) return -1;
        const int last = jacobian.cols[static_cast<std::size_t>(end) - 1];
        return last < num_kept ? -1 : (last - num_kept) / kLandmarkSize;
    };
    int num_landmarks = 0;
    for (int row = 0; row < jacobian.num_rows;) {
        const int landmark = landmark_of(row);
        if (landmark < 0) {
            const Rows rows = dense_rows(jacobian, {row});
            add(rows.columns, rows.J.transpose() * rows.J, others);
            ++row;
            continue;
        }
        std::vector<int> good;
        std::optional<Eigen::Vector3d> before;
        for (; row < jacobian.num_rows && landmark_of(row) == landmark; row += kRows) {
            const Eigen::Map<const Eigen::Vector3d> r(residuals.data() + row);
            const int measured = landmark_of(row + 2) == landmark && r.z() != 0.0 ? 3 : 2;
            const Eigen::Vector3d now = r;
            noise.add(now, before ? &*before : nullptr, measured);
            before = now;
            if (r.norm() > kOutlier * std::sqrt(static_cast<double>(measured))) continue;
            for (int i = 0; i < measured; ++i) good.push_back(row + i);
        }
        ++num_landmarks;
        noise.end_landmark();
        if (good.size() > kLandmarkSize) add_landmark(dense_rows(jacobian, good), cameras);
    }
    result.noise_scale = noise.scale(kLandmarkSize * num_landmarks + num_kept);
    result.lower = cameras.sum() / (result.noise_scale * result.noise_scale) + others.sum();
    return result;
}

}  // namespace divemesh::worker
