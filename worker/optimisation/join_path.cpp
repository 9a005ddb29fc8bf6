#include "worker/optimisation/join_path.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "worker/base/rotation_vector.hpp"

namespace divemesh::optimisation {
namespace {

using Matrix3X = Eigen::Matrix<double, 3, Eigen::Dynamic>;

constexpr double kDegreesOfFreedom = 4.0;
constexpr int kMaxIterations = 100;
constexpr double kStillSigmas = 0.03;
constexpr double kFixedOffset_m = 1e-6;
// Factors on the sigmas of the first iterations: outliers and runs that lie far off are reached.
constexpr std::array<double, 6> kWidening = {16.0, 16.0, 8.0, 4.0, 2.0, 2.0};

Eigen::Index at(std::size_t anchor) { return 6 * static_cast<Eigen::Index>(anchor); }

// Returns the matrix that takes the corrections of anchors in the world to unknowns: of each anchor
// the correction of its motion from the anchor before.
Eigen::MatrixXd unknowns_from_corrections(const AnchoredPath& path) {
    const Eigen::Index size = at(path.size());
    Eigen::MatrixXd M = Eigen::MatrixXd::Identity(size, size);
    for (std::size_t i = 1; i < path.size(); ++i) {
        const Eigen::Vector3d arm =
            path.T_world_imu(i).translation() - path.T_world_imu(i - 1).translation();
        M.block<6, 6>(at(i), at(i - 1)) = -Eigen::Matrix<double, 6, 6>::Identity();
        M.block<3, 3>(at(i), at(i - 1) + 3) = base::cross_matrix(arm);
    }
    return M;
}

// Returns the offsets of the anchors from the first, in the rows of their positions.
Eigen::VectorXd offsets(const AnchoredPath& path) {
    Eigen::VectorXd offset = Eigen::VectorXd::Zero(at(path.size()));
    for (std::size_t i = 0; i < path.size(); ++i)
        offset.segment<3>(at(i)) =
            path.T_world_imu(i).translation() - path.T_world_imu(0).translation();
    return offset;
}

// Returns L with L L^T the covariance of the unknowns. The last column is the error of the scale.
Eigen::MatrixXd root_of_prior(const AnchoredPath& path,
                              const types::PathPrior& prior,
                              const JoinSettings& settings) {
    const Eigen::VectorXd along = offsets(path);
    const double squared = along.squaredNorm();
    Eigen::MatrixXd covariance = prior.drift;
    if (!settings.calibration_is_exact) {
        Eigen::MatrixXd shared = prior.shared;
        if (squared > 0.0) shared -= along * (along.transpose() * shared) / squared;
        covariance += shared * shared.transpose();
    }
    const Eigen::MatrixXd M = unknowns_from_corrections(path);
    covariance = M * covariance * M.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        0.5 * (covariance + covariance.transpose()));
    Eigen::MatrixXd root(covariance.rows(), covariance.cols() + 1);
    root.leftCols(covariance.cols()) = settings.prior_factor * eigen.eigenvectors() *
                                       eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
    root.rightCols<1>() = settings.scale_sigma * (M * along);
    return root;
}

// A point after the correction of the path, and its derivatives with respect to the corrections of
// two anchors in the world.
struct MovedPoint {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 3, 6> J_a;
    Eigen::Matrix<double, 3, 6> J_b;
};

// One joining: the state of the iteration.
class Joining {
public:
    Joining(const AnchoredPath& path,
            const types::PathPrior& prior,
            const std::vector<OutsidePoint>& points,
            const std::vector<OutsideMotion>& motions,
            const Eigen::Isometry3d& T_site_world,
            const JoinSettings& settings)
        : path_(path),
          points_(points),
          motions_(motions),
          settings_(settings),
          root_(root_of_prior(path, prior, settings)),
          num_sources_(std::ssize(settings.offset_sigmas_m)),
          yaw_(std::atan2(T_site_world.linear()(1, 0), T_site_world.linear()(0, 0))) {
        for (const OutsidePoint& point : points_) center_ += point.p_world;
        if (!points_.empty()) center_ /= static_cast<double>(points_.size());
        place_ = T_site_world * center_;
        normal_ = Eigen::VectorXd::Zero(root_.cols());
        offsets_ = Eigen::VectorXd::Zero(3 * num_sources_);
    }

    JoinedPath run();

private:
    Eigen::Matrix3d R_site_world() const {
        return (base::rotation_from_vector({tilt_.x(), tilt_.y(), 0.0}) *
                Eigen::AngleAxisd(yaw_, Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    }
    Eigen::Index num_path() const { return root_.rows(); }
    Eigen::Index num_outer() const { return 6 + 3 * num_sources_; }

    MovedPoint moved(const AnchoredPath::Place& place, const Eigen::Vector3d& p_world) const;
    void correct_anchors();
    Eigen::Vector3d residual(const OutsidePoint& point, const MovedPoint& at_point) const;
    void linearise(double widening);
    void add_point(const OutsidePoint& point, double widening);
    void add_rows(const std::vector<std::pair<Eigen::Index, Matrix3X>>& blocks,
                  const Eigen::Vector3d& information,
                  const Eigen::Vector3d& r);
    void add_motion(const OutsideMotion& motion, double widening);
    double step();
    void add_priors(Eigen::MatrixXd& H, Eigen::VectorXd& g) const;
    JoinedPath result(bool converged, int num_iterations);
    Eigen::MatrixXd corrections_from_unknowns() const;

    const AnchoredPath& path_;
    const std::vector<OutsidePoint>& points_;
    const std::vector<OutsideMotion>& motions_;
    const JoinSettings& settings_;
    Eigen::MatrixXd root_;
    Eigen::Index num_sources_;
    Eigen::Vector3d center_ = Eigen::Vector3d::Zero();  // the world is rotated about it
    // Unknowns: independent standard normal numbers of the prior, the rotation, the place of the
    // centre, and the offsets.
    Eigen::VectorXd normal_;
    Eigen::Vector2d tilt_ = Eigen::Vector2d::Zero();
    double yaw_ = 0.0;
    Eigen::Vector3d place_ = Eigen::Vector3d::Zero();
    Eigen::VectorXd offsets_;
    // Normal equations over corrections, rotation, place and offsets.
    Eigen::VectorXd path_unknowns_;
    std::vector<Eigen::Isometry3d> T_new_old_;  // of each anchor
    Eigen::MatrixXd H_;
    Eigen::VectorXd g_;
    Eigen::MatrixXd covariance_;  // of the unknowns
};

JoinedPath Joining::run() {
    bool converged = false;
    int num_iterations = 0;
    while (!converged && num_iterations < kMaxIterations) {
        const auto i = static_cast<std::size_t>(num_iterations++);
        const bool widened = i < kWidening.size();
        linearise(widened ? kWidening[i] : 1.0);
        const double moved_sigmas = step();
        converged = !widened && moved_sigmas < kStillSigmas;
    }
    return result(converged, num_iterations);
}

// Returns exp(rotation) about an anchor, then the translation.
Eigen::Isometry3d motion_about(const Eigen::Vector3d& p_world,
                               const Eigen::Vector3d& translation,
                               const Eigen::Vector3d& rotation) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = base::rotation_from_vector(rotation).toRotationMatrix();
    T.translation() = p_world + translation - T.linear() * p_world;
    return T;
}

// Chains the corrections of the motions: a path that bends far stays as long as it is.
void Joining::correct_anchors() {
    path_unknowns_ = root_ * normal_;
    T_new_old_.clear();
    for (std::size_t i = 0; i < path_.size(); ++i) {
        const Eigen::Isometry3d own = motion_about(path_.T_world_imu(i).translation(),
                                                   path_unknowns_.segment<3>(at(i)),
                                                   path_unknowns_.segment<3>(at(i) + 3));
        T_new_old_.push_back(i == 0 ? own : T_new_old_.back() * own);
    }
}

MovedPoint Joining::moved(const AnchoredPath::Place& place, const Eigen::Vector3d& p_world) const {
    MovedPoint result;
    const auto add = [&](std::size_t anchor, double weight, Eigen::Matrix<double, 3, 6>& J) {
        const Eigen::Vector3d p_new = T_new_old_[anchor] * p_world;
        const Eigen::Vector3d arm =
            p_new - T_new_old_[anchor] * path_.T_world_imu(anchor).translation();
        result.p += weight * p_new;
        J << weight * Eigen::Matrix3d::Identity(), -weight * base::cross_matrix(arm);
    };
    add(place.a, 1.0 - place.weight_b, result.J_a);
    add(place.b, place.weight_b, result.J_b);
    return result;
}

Eigen::Vector3d Joining::residual(const OutsidePoint& point, const MovedPoint& at_point) const {
    return point.p_site - place_ - R_site_world() * (at_point.p - center_) -
           offsets_.segment<3>(3 * static_cast<Eigen::Index>(point.source));
}

// Returns the weight of a measurement by Student's t.
double student_weight(double squared, double num_rows) {
    return (kDegreesOfFreedom + num_rows) / (kDegreesOfFreedom + squared);
}

void Joining::linearise(double widening) {
    correct_anchors();
    H_ = Eigen::MatrixXd::Zero(num_path() + num_outer(), num_path() + num_outer());
    g_ = Eigen::VectorXd::Zero(H_.rows());
    for (const OutsidePoint& point : points_) add_point(point, widening);
    for (const OutsideMotion& motion : motions_) add_motion(motion, widening);
}

void Joining::add_point(const OutsidePoint& point, double widening) {
    const MovedPoint at_point = moved(path_.at(point.timestamp_ns), point.p_world);
    const Eigen::Vector3d r = residual(point, at_point);
    Eigen::Vector3d information = Eigen::Vector3d::Zero();
    information.head<2>().setConstant(1.0 / std::pow(widening * point.sigma_h_m, 2));
    if (point.sigma_v_m > 0.0) information.z() = 1.0 / std::pow(widening * point.sigma_v_m, 2);
    information *= student_weight(r.cwiseAbs2().dot(information), point.sigma_v_m > 0.0 ? 3 : 2);
    const Eigen::Matrix3d R = R_site_world();
    Matrix3X outer(3, 6);  // rotation and place
    outer << -base::cross_matrix(R * (at_point.p - center_)), Eigen::Matrix3d::Identity();
    const AnchoredPath::Place place = path_.at(point.timestamp_ns);
    add_rows({{at(place.a), R * at_point.J_a},
              {at(place.b), R * at_point.J_b},
              {num_path(), outer},
              {num_path() + 6 + 3 * static_cast<Eigen::Index>(point.source),
               Eigen::Matrix3d::Identity()}},
             information,
             r);
}

// Adds three rows to the normal equations: derivatives with the columns at which they begin.
void Joining::add_rows(const std::vector<std::pair<Eigen::Index, Matrix3X>>& blocks,
                       const Eigen::Vector3d& information,
                       const Eigen::Vector3d& r) {
    for (const auto& [row, J_row] : blocks) {
        const Eigen::MatrixXd weighted = J_row.transpose() * information.asDiagonal();
        g_.segment(row, J_row.cols()) += weighted * r;
        for (const auto& [column, J_column] : blocks)
            H_.block(row, column, J_row.cols(), J_column.cols()) += weighted * J_column;
    }
}

void Joining::add_motion(const OutsideMotion& motion, double widening) {
    const auto p_new = [&](std::size_t anchor) -> Eigen::Vector3d {
        return T_new_old_[anchor] * path_.T_world_imu(anchor).translation();
    };
    const Eigen::Vector3d motion_world = T_new_old_[motion.from].linear() *
                                         path_.T_world_imu(motion.from).linear() *
                                         motion.motion_imu;
    const Eigen::Vector3d r = motion_world - (p_new(motion.from + 1) - p_new(motion.from));
    const double information = 1.0 / std::pow(widening * motion.sigma_m, 2);
    Matrix3X J_from(3, 6);  // a rotation there rotates the motion too
    J_from << -Eigen::Matrix3d::Identity(), base::cross_matrix(motion_world);
    Matrix3X J_to = Matrix3X::Zero(3, 6);
    J_to.leftCols<3>().setIdentity();
    add_rows(
        {{at(motion.from), J_from}, {at(motion.from + 1), J_to}},
        Eigen::Vector3d::Constant(information * student_weight(information * r.squaredNorm(), 3.0)),
        r);
}

void Joining::add_priors(Eigen::MatrixXd& H, Eigen::VectorXd& g) const {
    const Eigen::Index num_normal = root_.cols();
    H.topLeftCorner(num_normal, num_normal).diagonal().array() += 1.0;
    g.head(num_normal) -= normal_;
    const double of_tilt = 1.0 / std::pow(settings_.tilt_sigma_rad, 2);
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
        H(num_normal + axis, num_normal + axis) += of_tilt;
        g[num_normal + axis] -= of_tilt * tilt_[axis];
    }
    for (Eigen::Index i = 0; i < 3 * num_sources_; ++i) {
        const double stated_m = settings_.offset_sigmas_m[static_cast<std::size_t>(i / 3)];
        const double sigma_m = i % 3 < 2 ? std::max(stated_m, kFixedOffset_m) : kFixedOffset_m;
        H(num_normal + 6 + i, num_normal + 6 + i) += 1.0 / (sigma_m * sigma_m);
        g[num_normal + 6 + i] -= offsets_[i] / (sigma_m * sigma_m);
    }
}

// Solves for a step and takes it. Returns how far it moved the unknown that moved most, in its
// standard deviations.
double Joining::step() {
    const Eigen::Index num_normal = root_.cols();
    const Eigen::Index size = num_normal + num_outer();
    const Eigen::MatrixXd root = corrections_from_unknowns() * root_;
    Eigen::MatrixXd H(size, size);
    H.topLeftCorner(num_normal, num_normal) =
        root.transpose() * H_.topLeftCorner(num_path(), num_path()) * root;
    H.topRightCorner(num_normal, num_outer()) =
        root.transpose() * H_.topRightCorner(num_path(), num_outer());
    H.bottomLeftCorner(num_outer(), num_normal) =
        H.topRightCorner(num_normal, num_outer()).transpose();
    H.bottomRightCorner(num_outer(), num_outer()) = H_.bottomRightCorner(num_outer(), num_outer());
    Eigen::VectorXd g(size);
    g << root.transpose() * g_.head(num_path()), g_.tail(num_outer());
    add_priors(H, g);
    // What no measurement tells, as a height, stays where it is.
    constexpr double kUnknown_m = 1e4;
    H.diagonal().segment<6>(num_normal).array() += 1.0 / (kUnknown_m * kUnknown_m);
    const Eigen::LDLT<Eigen::MatrixXd> factor(H);
    covariance_ = factor.solve(Eigen::MatrixXd::Identity(size, size));
    const Eigen::VectorXd moved = factor.solve(g);
    normal_ += moved.head(num_normal);
    tilt_ += moved.segment<2>(num_normal);
    yaw_ += moved[num_normal + 2];
    place_ += moved.segment<3>(num_normal + 3);
    offsets_ += moved.tail(3 * num_sources_);
    return moved.cwiseAbs().cwiseQuotient(covariance_.diagonal().cwiseAbs().cwiseSqrt()).maxCoeff();
}

// Returns the matrix that takes unknowns to the corrections of anchors in the world, about the
// corrected path: every anchor up to one moves it along, and rotates it about itself.
Eigen::MatrixXd Joining::corrections_from_unknowns() const {
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(num_path(), num_path());
    for (std::size_t k = 0; k < path_.size(); ++k) {
        const Eigen::Matrix3d R =
            k == 0 ? Eigen::Matrix3d::Identity().eval() : T_new_old_[k - 1].linear().eval();
        const Eigen::Vector3d p_k = T_new_old_[k] * path_.T_world_imu(k).translation();
        for (std::size_t i = k; i < path_.size(); ++i) {
            const Eigen::Vector3d arm = T_new_old_[i] * path_.T_world_imu(i).translation() - p_k;
            M.block<3, 3>(at(i), at(k)) = R;
            M.block<3, 3>(at(i), at(k) + 3) = -base::cross_matrix(arm) * R;
            M.block<3, 3>(at(i) + 3, at(k) + 3) = R;
        }
    }
    return M;
}

JoinedPath Joining::result(bool converged, int num_iterations) {
    correct_anchors();
    JoinedPath joined{.converged = converged && normal_.allFinite() && place_.allFinite(),
                      .num_iterations = num_iterations};
    joined.T_site_world.linear() = R_site_world();
    joined.T_site_world.translation() = place_ - R_site_world() * center_;
    // The world is levelled about the first pose: its z axis is that of the site.
    const Eigen::Matrix3d R_yaw =
        Eigen::AngleAxisd(yaw_, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Eigen::Matrix3d R_level = R_yaw.transpose() * R_site_world();
    const Eigen::Vector3d p_first = path_.T_world_imu(0).translation();
    Eigen::Isometry3d T_level = Eigen::Isometry3d::Identity();
    T_level.linear() = R_level;
    T_level.translation() = p_first - R_level * p_first;
    for (const Eigen::Isometry3d& T : T_new_old_) joined.T_new_old.push_back(T_level * T);
    joined.T_site_world = joined.T_site_world * T_level.inverse();
    const Eigen::Index num_normal = root_.cols();
    Eigen::MatrixXd M = corrections_from_unknowns() * root_;
    for (Eigen::Index row = 0; row < M.rows(); row += 3)
        M.middleRows<3>(row) = (R_level * M.middleRows<3>(row)).eval();
    const Eigen::MatrixXd of_drift = M.leftCols(num_normal - 1) / settings_.prior_factor;
    joined.prior_covariance =
        of_drift * of_drift.transpose() + M.rightCols<1>() * M.rightCols<1>().transpose();
    joined.covariance = M * covariance_.topLeftCorner(num_normal, num_normal) * M.transpose();
    const Eigen::Vector3d start_m = R_site_world() * (path_.T_world_imu(0).translation() - center_);
    Eigen::Matrix<double, 6, 6> to_start = Eigen::Matrix<double, 6, 6>::Identity();
    to_start.bottomLeftCorner<3, 3>() = -base::cross_matrix(start_m);
    joined.site_covariance =
        to_start * covariance_.block<6, 6>(num_normal, num_normal) * to_start.transpose();
    joined.scale_error = settings_.scale_sigma * normal_[num_normal - 1];
    joined.scale_error_sigma =
        settings_.scale_sigma * std::sqrt(covariance_(num_normal - 1, num_normal - 1));
    joined.moved_sigmas = normal_.cwiseAbs().maxCoeff();
    joined.moved_squares = normal_.squaredNorm();
    joined.num_determined =
        static_cast<double>(num_normal) - covariance_.topLeftCorner(num_normal, num_normal).trace();
    for (const OutsidePoint& point : points_)
        joined.residuals_m.push_back(
            residual(point, moved(path_.at(point.timestamp_ns), point.p_world)));
    return joined;
}

}  // namespace

JoinedPath join_path(const AnchoredPath& path,
                     const types::PathPrior& prior,
                     const std::vector<OutsidePoint>& points,
                     const std::vector<OutsideMotion>& motions,
                     const Eigen::Isometry3d& T_site_world,
                     const JoinSettings& settings) {
    return Joining(path, prior, points, motions, T_site_world, settings).run();
}

}  // namespace divemesh::optimisation
