#include "worker/evaluation/truth_registration.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "schemas/error.hpp"
#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/evaluation/alignment.hpp"
#include "worker/evaluation/motion_correlation.hpp"
#include "worker/evaluation/trajectory_pairs.hpp"
#include "worker/io/solver_json.hpp"

namespace divemesh::evaluation {
namespace {

using Matrix10d = Eigen::Matrix<double, 10, 10>;
using Vector10d = Eigen::Matrix<double, 10, 1>;

constexpr double kMinRotationSine = 0.035;  // RMS sine of the rotation that determines a lever arm
constexpr double kMinVelocity = 0.02;       // m/s, RMS of the velocity that determines an offset
// beyond it the truth's axes do not belong to this body
constexpr double kMaxOrientationRms_deg = 5;
constexpr std::size_t kMinPoses = 20;
constexpr double kMinSigma_m = 1e-6;  // of a position; no tracker is better
constexpr double kReach_s = 0.2;      // in both directions, for a velocity

types::Trajectory shifted(types::Trajectory trajectory, double offset_s) {
    for (types::StampedPose& pose : trajectory) pose.timestamp_ns -= base::to_ns(offset_s);
    return trajectory;
}

// The solved quantities: rotation and translation between the worlds, lever arm, offset; parameters
// 0-2, 3-5, 6-8, 9 of the equations.
struct State {
    Eigen::Isometry3d T_reference_world = Eigen::Isometry3d::Identity();
    Eigen::Vector3d lever_m = Eigen::Vector3d::Zero();
    double offset_s = 0.0;
};

// The residual of a true position and its derivative with respect to each parameter.
struct Row {
    Eigen::Vector3d residual;
    Eigen::Matrix<double, 3, 10> J = Eigen::Matrix<double, 3, 10>::Zero();
};

double squares_m2(const std::vector<Row>& rows) {
    double sum = 0.0;
    for (const Row& row : rows) sum += row.residual.squaredNorm();
    return sum;
}

class Registration {
public:
    Registration(const types::Trajectory& estimate,
                 const types::Trajectory& truth,
                 const TruthOptions& options)
        : estimate_(estimate), truth_(truth), options_(options) {
        const double duration_s =
            base::to_s(estimate.back().timestamp_ns - estimate.front().timestamp_ns);
        reach_ = static_cast<std::size_t>(
            std::ceil(kReach_s * static_cast<double>(estimate.size() - 1) / duration_s));
    }

    std::vector<Row> rows(const State& state) const {
        std::vector<Row> result;
        const Eigen::Matrix3d R = state.T_reference_world.linear();
        for (std::size_t i = 0; i < estimate_.size(); ++i) {
            const auto& [time_ns, T_world_body] = estimate_[i];
            const auto truth = pose_at(truth_, time_ns + base::to_ns(state.offset_s));
            if (!truth) continue;
            const Eigen::Vector3d p_world = T_world_body * state.lever_m;
            Row row;
            row.residual = truth->translation() - state.T_reference_world * p_world;
            row.J.block<3, 3>(0, 0) = R * base::cross_matrix(p_world);
            row.J.block<3, 3>(0, 3) = -Eigen::Matrix3d::Identity();
            if (options_.solve_lever_arm) row.J.block<3, 3>(0, 6) = -R * T_world_body.linear();
            if (options_.solve_time_offset) row.J.col(9) = R * velocity_world(i, state.lever_m);
            result.push_back(row);
        }
        return result;
    }

    struct Solution {
        State state;
        types::SolverOutcome outcome;
    };

    // Solves by Gauss-Newton. Returns nullopt if poses move outside the truth during the
    // iterations.
    std::optional<Solution> solve(State state) const {
        constexpr int kMaxIterations = 50;
        constexpr double kConverged = 1e-8;  // rad, m, s; stamps are whole nanoseconds
        using Termination = types::SolverOutcome::Termination;
        types::SolverOutcome outcome{.termination = Termination::StoppedAtLimit,
                                     .message = "the last step was still large"};
        const types::Trajectory here = shifted(truth_, state.offset_s);
        auto pairs = pair_poses(estimate_, here, {});
        if (pairs.size() < kMinPoses) return std::nullopt;
        for (PosePair& pair : pairs) pair.T_world_body.translate(state.lever_m);
        state.T_reference_world = align(pairs).T_reference_world;
        for (int i = 0; i < kMaxIterations; ++i) {
            const auto equations = rows(state);
            if (equations.size() < kMinPoses) return std::nullopt;
            const double cost = squares_m2(equations);
            if (i == 0) outcome.initial_cost = cost;
            if (i > 0) outcome.last_decrease = (outcome.final_cost - cost) / outcome.final_cost;
            outcome.final_cost = cost;
            const Step step = step_of(equations);
            if (!step.change.allFinite()) return std::nullopt;
            apply(step.change, state);
            outcome.last_step_sigmas = step.sigmas;
            ++outcome.num_iterations;
            if (step.change.norm() < kConverged) {
                outcome.termination = Termination::Converged;
                outcome.message = "the last step was small";
                break;
            }
        }
        return Solution{state, outcome};
    }

private:
    // Returns the velocity of the marker over a time in which it moves more than its error. It is
    // the estimate's velocity, because a tracker's differentiated noise would count as motion that
    // determines the offset.
    Eigen::Vector3d velocity_world(std::size_t i, const Eigen::Vector3d& lever_m) const {
        const types::StampedPose& before = estimate_[i - std::min(i, reach_)];
        const types::StampedPose& after = estimate_[std::min(i + reach_, estimate_.size() - 1)];
        const double seconds = base::to_s(after.timestamp_ns - before.timestamp_ns);
        return (after.T_world_imu * lever_m - before.T_world_imu * lever_m) / seconds;
    }

    struct Step {
        Vector10d change;
        double sigmas = 0.0;  // RMS over the parameters
    };

    static Step step_of(const std::vector<Row>& equations) {
        Matrix10d H = Matrix10d::Zero();
        Vector10d gradient = Vector10d::Zero();
        for (const Row& row : equations) {
            H += row.J.transpose() * row.J;
            gradient -= row.J.transpose() * row.residual;
        }
        // Parameters that are fixed or unobservable do not change.
        const Vector10d change = H.completeOrthogonalDecomposition().solve(gradient);
        const auto num_free = static_cast<double>((H.diagonal().array() > 0.0).count());
        const double variance_m2 =
            std::max(kMinSigma_m * kMinSigma_m,
                     squares_m2(equations) / (3.0 * static_cast<double>(equations.size())));
        return {change, std::sqrt(change.dot(H * change) / (num_free * variance_m2))};
    }

    static void apply(const Vector10d& step, State& state) {
        constexpr double kMaxStep_s = 0.5;
        state.T_reference_world.linear() =
            state.T_reference_world.linear() *
            base::rotation_from_vector(step.segment<3>(0)).toRotationMatrix();
        state.T_reference_world.translation() += step.segment<3>(3);
        state.lever_m += step.segment<3>(6);
        state.offset_s += std::clamp(step[9], -kMaxStep_s, kMaxStep_s);
    }

    const types::Trajectory& estimate_;
    const types::Trajectory& truth_;
    const TruthOptions& options_;
    std::size_t reach_ = 1;  // frames
};

double rms_m(const std::vector<Row>& rows) {
    return std::sqrt(squares_m2(rows) / static_cast<double>(rows.size()));
}

// Returns the integrated autocorrelation time of the residuals, in samples, up to the first lag at
// which they are no longer correlated.
double autocorrelation_time(const std::vector<Row>& rows) {
    const auto at = [&](std::size_t lag) {
        double sum = 0.0;
        for (std::size_t i = lag; i < rows.size(); ++i)
            sum += rows[i].residual.dot(rows[i - lag].residual);
        return sum;
    };
    const double power = at(0);
    if (power <= 0.0) return 1.0;
    double time = 1.0;
    for (std::size_t lag = 1; lag < rows.size() / 2; ++lag) {
        const double together = at(lag) / power;
        if (together <= 0.0) break;
        time += 2.0 * together;
    }
    return time;
}

// Returns the variances from the scatter of the gradients over tenths of the path (cluster-robust,
// Liang and Zeger 1986), which fully includes errors as slow as the motion that determines a
// parameter.
Vector10d clustered_variances(const std::vector<Row>& rows, const Matrix10d& H) {
    constexpr std::size_t kNumClusters = 10;
    Matrix10d scatter = Matrix10d::Zero();
    for (std::size_t cluster = 0; cluster < kNumClusters; ++cluster) {
        Vector10d gradient = Vector10d::Zero();
        for (std::size_t i = cluster * rows.size() / kNumClusters;
             i < (cluster + 1) * rows.size() / kNumClusters;
             ++i)
            gradient += rows[i].J.transpose() * rows[i].residual;
        scatter += gradient * gradient.transpose();
    }
    const Matrix10d inverse = H.completeOrthogonalDecomposition().pseudoInverse();
    constexpr double kFewClusters = kNumClusters / (kNumClusters - 1.0);
    return kFewClusters * (inverse * scatter * inverse).diagonal();
}

// Returns the information on some parameters when the others are free (Schur complement).
Eigen::MatrixXd reduced(const Matrix10d& H, const std::vector<int>& kept) {
    std::vector<int> others;
    for (int i = 0; i < 10; ++i)
        if (std::find(kept.begin(), kept.end(), i) == kept.end() && H(i, i) > 0.0)
            others.push_back(i);
    const Eigen::MatrixXd across = H(kept, others);
    const Eigen::MatrixXd theirs = H(others, others);
    return H(kept, kept) -
           across * theirs.completeOrthogonalDecomposition().solve(across.transpose());
}

std::string vector_text(const Eigen::Vector3d& v) {
    char text[80];
    std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f)", v.x(), v.y(), v.z());
    return text;
}

// Throws if the poses do not determine the solved quantities; otherwise sets their standard
// deviations.
void check_observability(const std::vector<Row>& rows,
                         const TruthOptions& options,
                         TruthRegistration& result) {
    Matrix10d H = Matrix10d::Zero();
    for (const Row& row : rows) H += row.J.transpose() * row.J;
    const auto num_poses = static_cast<double>(rows.size());
    const auto num_free = static_cast<double>((H.diagonal().array() > 0.0).count());
    const double variance_m2 = num_poses * result.residual_rms_m * result.residual_rms_m /
                               (3.0 * num_poses - num_free) * autocorrelation_time(rows);
    const Vector10d clustered = clustered_variances(rows, H);
    if (options.solve_lever_arm) {
        const Eigen::Matrix3d information = reduced(H, {6, 7, 8});
        // The offset is taken as known; its effect is in the deviations.
        Matrix10d known_offset = H;
        known_offset.row(9).setZero();
        known_offset.col(9).setZero();
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
            reduced(known_offset, {6, 7, 8}));
        if (solver.eigenvalues()[0] < kMinRotationSine * kMinRotationSine * num_poses)
            throw Error(ErrorCode::BadData,
                        "the lever arm cannot be solved, because the rig hardly rotated about "
                        "anything but " +
                            vector_text(solver.eigenvectors().col(0)) +
                            " of its axes: give the lever arm as measured, or rotate the rig about "
                            "two axes while the tracker sees it");
        result.lever_arm_sigma_m = (variance_m2 * information.inverse())
                                       .diagonal()
                                       .cwiseMax(clustered.segment<3>(6))
                                       .cwiseSqrt();
    }
    if (options.solve_time_offset) {
        const double information = reduced(H, {9})(0, 0);
        if (information < kMinVelocity * kMinVelocity * num_poses)
            throw Error(ErrorCode::BadData,
                        "the time offset cannot be solved, because the velocity of the rig hardly "
                        "changed: give the offset, or move back and forth at the start");
        result.time_offset_sigma_s = std::sqrt(std::max(variance_m2 / information, clustered[9]));
    }
}

// Solves for the marker's axes on the body: the mean over all poses (chordal) and the scatter of
// single poses. Keeps only the positions if the truth's orientations are not those of this body.
void solve_axes(const types::Trajectory& estimate,
                const types::Trajectory& truth,
                const State& state,
                double samples_together,
                TruthRegistration& result) {
    std::vector<Eigen::Matrix3d> rotations;
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (const auto& [time_ns, T_world_body] : estimate) {
        const auto marker = pose_at(truth, time_ns + base::to_ns(state.offset_s));
        if (!marker) continue;
        rotations.push_back((state.T_reference_world.linear() * T_world_body.linear()).transpose() *
                            marker->linear());
        sum += rotations.back();
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
    const Eigen::Matrix3d R_body_marker =
        svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    double squares = 0.0;
    for (const Eigen::Matrix3d& rotation : rotations) {
        const double angle = base::angle_rad(R_body_marker.transpose() * rotation);
        squares += angle * angle;
    }
    const auto count = static_cast<double>(rotations.size());
    const double rms_deg = base::kDegPerRad * std::sqrt(squares / count);
    result.has_orientation = rms_deg <= kMaxOrientationRms_deg;
    if (!result.has_orientation) return;
    result.T_body_marker.linear() = R_body_marker;
    result.rotation_sigma_deg = rms_deg * std::sqrt(std::min(1.0, samples_together / count));
}

State initial_state(const TruthOptions& options) {
    State state;
    state.offset_s = options.time_offset_s;
    if (options.lever_arm)
        state.lever_m = Eigen::Map<const Eigen::Vector3d>(options.lever_arm->position_m.data());
    return state;
}

TruthRegistration as_given(const TruthOptions& options) {
    TruthRegistration result;
    result.time_offset_s = options.time_offset_s;
    if (!options.lever_arm) return result;
    const auto& q = options.lever_arm->orientation_wxyz;
    result.T_body_marker.linear() =
        Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    result.T_body_marker.translation() = initial_state(options).lever_m;
    return result;
}

// Returns the best of the solutions that start at each likely offset.
Registration::Solution best_solution(const Registration& registration,
                                     const types::Trajectory& estimate,
                                     const types::Trajectory& truth,
                                     const TruthOptions& options) {
    std::vector<double> offsets_s = {options.time_offset_s};
    if (options.solve_time_offset) offsets_s = likely_time_offsets_s(estimate, truth);
    std::optional<Registration::Solution> best;
    double best_rms_m = std::numeric_limits<double>::infinity();
    for (const double offset_s : offsets_s) {
        State start = initial_state(options);
        start.offset_s = offset_s;
        const auto solved = registration.solve(start);
        if (!solved) continue;
        const auto rows = registration.rows(solved->state);
        if (rows.size() < kMinPoses || rms_m(rows) >= best_rms_m) continue;
        best_rms_m = rms_m(rows);
        best = solved;
    }
    if (best && best->outcome.still_moving())
        throw Error(ErrorCode::BadData,
                    "lever arm or time offset cannot be solved, because " +
                        std::to_string(best->outcome.num_iterations) +
                        " iterations did not suffice: give both as measured");
    if (best) return *best;
    throw Error(ErrorCode::BadData,
                options.solve_time_offset && offsets_s.empty()
                    ? "the time offset cannot be solved, because the two trajectories do not match "
                      "at any offset: check that they are of the same dive"
                    : "fewer than " + std::to_string(kMinPoses) +
                          " poses have ground truth at their time: check the offset of the clocks");
}

}  // namespace

TruthRegistration register_truth(const types::Trajectory& estimate,
                                 const types::Trajectory& truth,
                                 const TruthOptions& options) {
    TruthRegistration result = as_given(options);
    result.has_orientation = has_rotation(truth) || !has_rotation(estimate);
    if (!options.solve_lever_arm && !options.solve_time_offset) return result;
    if (estimate.size() < kMinPoses)
        throw Error(ErrorCode::BadData,
                    "the estimate has fewer than " + std::to_string(kMinPoses) +
                        " poses, too few to solve lever arm or time offset: give both as measured");
    const Registration registration(estimate, truth, options);
    const auto [state, outcome] = best_solution(registration, estimate, truth, options);
    result.outcome = outcome;
    const auto rows = registration.rows(state);
    result.num_poses = std::ssize(rows);
    result.residual_rms_m = rms_m(rows);
    result.time_offset_s = state.offset_s;
    result.T_body_marker.translation() = state.lever_m;
    check_observability(rows, options, result);
    if (options.solve_lever_arm && result.has_orientation)
        solve_axes(estimate, truth, state, autocorrelation_time(rows), result);
    return result;
}

RegisteredTruth registered_truth(const types::Trajectory& estimate,
                                 types::Trajectory truth,
                                 const TruthOptions& options) {
    RegisteredTruth result;
    result.registration = register_truth(estimate, truth, options);
    result.poses = shifted(std::move(truth), result.registration.time_offset_s);
    result.options.T_referencebody_estimatebody = result.registration.T_body_marker.inverse();
    if (result.registration.has_orientation) return result;
    const auto pairs = pair_poses(estimate, result.poses, result.options);
    if (pairs.size() < 3) return result;
    const Eigen::Matrix3d R_reference_world = align(pairs).T_reference_world.linear();
    result.poses.clear();
    for (const PosePair& pair : pairs) {
        Eigen::Isometry3d pose = pair.T_reference_body;
        pose.linear() = R_reference_world * pair.T_world_body.linear();
        result.poses.push_back({pair.timestamp_ns, pose});
    }
    return result;
}

nlohmann::json to_metrics(const TruthRegistration& registration, const TruthOptions& options) {
    const Eigen::Vector3d p = registration.T_body_marker.translation();
    const Eigen::Quaterniond q(registration.T_body_marker.linear());
    nlohmann::json json = {
        {"positions_only", !registration.has_orientation},
        {"time_offset_s", {{"value", registration.time_offset_s}, {"how", "given"}}},
        {"lever_arm_m", {{"vector", {p.x(), p.y(), p.z()}}, {"how", "given"}}},
        {"marker_orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
    if (options.time_offset_s == 0.0) json["time_offset_s"]["how"] = "none";
    if (!options.lever_arm) json["lever_arm_m"]["how"] = "none";
    if (registration.num_poses == 0) return json;
    json["num_poses"] = registration.num_poses;
    json["residual_rms_m"] = registration.residual_rms_m;
    json["solver"] = io::to_json(registration.outcome);
    if (const auto sigma_s = registration.time_offset_sigma_s) {
        json["time_offset_s"]["how"] = "solved";
        json["time_offset_s"]["sigma"] = *sigma_s;
    }
    if (const auto sigma_m = registration.lever_arm_sigma_m) {
        json["lever_arm_m"]["how"] = "solved";
        json["lever_arm_m"]["sigma"] = {sigma_m->x(), sigma_m->y(), sigma_m->z()};
    }
    if (registration.rotation_sigma_deg)
        json["marker_rotation_sigma_deg"] = *registration.rotation_sigma_deg;
    return json;
}

nlohmann::json without_rotations(nlohmann::json trajectory) {
    trajectory.erase("rotation_rmse_deg");
    for (const char* part : {"revisit", "relative_pose"})
        if (trajectory.contains(part)) trajectory[part].erase("rotation_rmse_deg");
    if (!trajectory.contains("segments")) return trajectory;
    for (nlohmann::json& segment : trajectory["segments"])
        for (const char* metric : {"rotation_mean_deg_per_m", "rotation_rmse_deg_per_m"})
            segment.erase(metric);
    return trajectory;
}

}  // namespace divemesh::evaluation
