#include "worker/optimisation/refine_pose_by_ceres.hpp"

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/ceres_outcome.hpp"
#include "worker/optimisation/residuals/point_transfer.hpp"
#include "worker/optimisation/residuals/rotation_prior.hpp"

namespace divemesh::optimisation {

odometry::RefinedPose refine_pose_by_ceres(const types::RectifiedRig& rig,
                                           const odometry::PointPairs& pairs,
                                           const odometry::MotionGuess& guess) {
    Eigen::Vector3d rodrigues =
        base::vector_from_rotation(Eigen::Quaterniond(guess.T_current_previous.linear()));
    Eigen::Vector3d translation = guess.T_current_previous.translation();
    ceres::Problem problem;
    for (const odometry::PointPair& pair : pairs)
        problem.AddResidualBlock(PointTransfer::create({rig,
                                                        pair.previous_px,
                                                        pair.current_px,
                                                        pair.previous_sigma_px,
                                                        pair.current_sigma_px}),
                                 new ceres::HuberLoss(2.0),
                                 rodrigues.data(),
                                 translation.data());
    if (guess.rotation)
        problem.AddResidualBlock(
            RotationPrior::create(guess.rotation->q, guess.rotation->sigma_rad),
            nullptr,
            rodrigues.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 10;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    odometry::RefinedPose refined{guess.T_current_previous, outcome_of(summary)};
    if (!summary.IsSolutionUsable()) return refined;
    Eigen::Isometry3d& T_current_previous = refined.T_current_previous;
    T_current_previous.linear() = base::rotation_from_vector(rodrigues).toRotationMatrix();
    T_current_previous.translation() = translation;
    return refined;
}

}  // namespace divemesh::optimisation
