#include "worker/loops/pose_graph.hpp"

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "worker/optimisation/ceres_outcome.hpp"
#include "worker/optimisation/residuals/relative_pose.hpp"

namespace divemesh::loops {
namespace {

constexpr double kLoopSigma_rad = 0.003;
// Share of a step between keyframes in a drift that grows with the square root of the distance.
constexpr double kStepShare = 0.2;

struct Pose {
    Eigen::Quaterniond q_world_cam;
    Eigen::Vector3d p_world_cam;
};

}  // namespace

types::SolverOutcome optimise_pose_graph(const std::vector<Loop>& loops,
                                         const DriftModel& drift,
                                         std::vector<types::Keyframe>& keyframes,
                                         std::vector<types::Landmark>& landmarks,
                                         int max_num_iterations) {
    std::vector<Pose> poses;
    poses.reserve(keyframes.size());
    for (const types::Keyframe& keyframe : keyframes)
        poses.push_back({Eigen::Quaterniond(keyframe.T_world_cam.linear()).normalized(),
                         keyframe.T_world_cam.translation()});
    ceres::EigenQuaternionManifold rotation;
    ceres::Problem::Options problem_options;
    problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(problem_options);
    for (Pose& pose : poses) {
        problem.AddParameterBlock(pose.q_world_cam.coeffs().data(), 4, &rotation);
        problem.AddParameterBlock(pose.p_world_cam.data(), 3);
    }
    problem.SetParameterBlockConstant(poses.front().q_world_cam.coeffs().data());
    problem.SetParameterBlockConstant(poses.front().p_world_cam.data());
    const auto tie = [&](std::size_t a,
                         std::size_t b,
                         const Eigen::Isometry3d& T_a_b,
                         double sigma_m,
                         double sigma_rad) {
        problem.AddResidualBlock(optimisation::RelativePose::create(T_a_b, sigma_m, sigma_rad),
                                 nullptr,
                                 poses[a].q_world_cam.coeffs().data(),
                                 poses[a].p_world_cam.data(),
                                 poses[b].q_world_cam.coeffs().data(),
                                 poses[b].p_world_cam.data());
    };
    for (std::size_t k = 1; k < keyframes.size(); ++k)
        tie(k - 1,
            k,
            keyframes[k - 1].T_world_cam.inverse() * keyframes[k].T_world_cam,
            kStepShare * drift.position_sigma_m(k - 1, k),
            kStepShare * drift.orientation_sigma_rad(k - 1, k));
    for (const Loop& loop : loops)
        tie(loop.from, loop.to, loop.T_from_to, loop.sigma_m, kLoopSigma_rad);

    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = max_num_iterations;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    types::SolverOutcome outcome = optimisation::outcome_of(summary);
    if (outcome.failed()) return outcome;

    std::vector<Eigen::Isometry3d> T_new_old(keyframes.size());
    for (std::size_t k = 0; k < keyframes.size(); ++k) {
        Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
        T_world_cam.linear() = poses[k].q_world_cam.normalized().toRotationMatrix();
        T_world_cam.translation() = poses[k].p_world_cam;
        T_new_old[k] = T_world_cam * keyframes[k].T_world_cam.inverse();
        keyframes[k].T_world_cam = T_world_cam;
    }
    for (types::Landmark& landmark : landmarks) {
        const auto anchor = static_cast<std::size_t>(landmark.observations.front().keyframe);
        landmark.p_world = T_new_old[anchor] * landmark.p_world;
    }
    return outcome;
}

}  // namespace divemesh::loops
