#pragma once

#include <Eigen/Geometry>
#include <array>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/ordered_groups.h>
#include <ceres/problem.h>
#include <optional>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/calibration/calibration_priors.hpp"
#include "worker/calibration/lens_reprojection.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/rolling_shutter.hpp"
#include "worker/imu/inertial_prior.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track.hpp"

namespace divemesh::calibration {

// The unknowns of the calibration.
struct CalibrationUnknowns {
    Eigen::Vector3d misalignment = Eigen::Vector3d::Zero();  // rad, q_body_imu as a vector
    double time_offset_s = 0.0;
    Eigen::Vector3d rate_error = Eigen::Vector3d::Zero();  // as types::ImuAlignment
    LensChanges lenses = LensChanges::Zero();              // left, right
    double readout_time_s = 0.0;  // of a rolling shutter; see camera::RollingShutter
};

// The uncertainty of the unknowns after the last round.
struct CalibrationSigmas {
    Eigen::Matrix3d misalignment = Eigen::Matrix3d::Zero();  // covariance, rad^2
    double time_offset_s = 0.0;
    Eigen::Matrix3d rate_error = Eigen::Matrix3d::Zero();  // covariance; zero where it was held
    LensCovariance lenses = LensCovariance::Zero();
    double readout_time_s = 0.0;
};

// Which unknowns of the cameras are free; those of the IMU always are, except the error of its
// rates: that is free if the cameras are held, as another focal length looks the same.
struct FreeUnknowns {
    bool lenses = false;
    bool readout_time = false;

    bool any() const { return lenses || readout_time; }
};

// Returns the changes of the left and of the right camera.
std::array<types::LensChange, 2> split(const LensChanges& changes);

// The bundle adjustment of a dive with its calibration free.
class CalibrationProblem {
public:
    static constexpr int kMaxRounds = 4;

    CalibrationProblem(const types::Track& track,
                       const types::Recording& recording,
                       const types::RigAlignment& alignment,
                       const imu::InertialPrior& inertial);

    // Solves in rounds of least squares, each linearised in time offset and lenses at the last
    // result. Returns how the last round ended, with the iterations and the first cost of them all;
    // StoppedAtLimit also if the unknowns still changed in it (by `last_step_sigmas`), Failed also
    // if they have no covariance.
    types::SolverOutcome solve(const FreeUnknowns& free,
                               const base::ProgressCallback& progress,
                               const Progress& at,
                               int max_rounds = kMaxRounds);
    void hold_lenses(const LensChanges& changes) { unknowns_.lenses = changes; }
    void hold_rate_error(const Eigen::Vector3d& error) { unknowns_.rate_error = error; }
    // Uses every `stride`-th landmark from now on.
    void thin(std::size_t stride) { stride_ = stride; }
    // Returns true if the motion is known at a keyframe. Otherwise the readout time cannot be
    // estimated.
    bool knows_motion() const;
    const CalibrationUnknowns& unknowns() const { return unknowns_; }
    const CalibrationSigmas& sigmas() const { return sigmas_; }
    // Returns how far a change of the lenses moves the image and the disparities, RMS, px, without
    // the part that a rotation of the cameras would explain too.
    double shift_px(const LensChanges& changes) const;
    // Returns how far a readout time moves the observations, RMS, px.
    double shift_by_readout_px(double readout_time_s) const;

private:
    struct State {
        Eigen::Quaterniond q_world_body = Eigen::Quaterniond::Identity();
        Eigen::Vector3d p_world_body = Eigen::Vector3d::Zero();
        Eigen::Vector3d gyroscope_bias_imu = Eigen::Vector3d::Zero();  // rad/s
    };
    struct Round {
        types::SolverOutcome outcome;
        bool still = false;  // the unknowns changed too little for another round to be needed
        CalibrationUnknowns before_last_step;
    };
    // Does one round. It finds the sigmas if `last` is true or the unknowns are still.
    Round round(const FreeUnknowns& free,
                bool last,
                const base::ProgressCallback& progress,
                const Progress& at);
    void add_observations(ceres::Problem& problem,
                          ceres::ParameterBlockOrdering& ordering,
                          const FreeUnknowns& free);
    void add_gyro_rotations(ceres::Problem& problem);
    // Adds very weak factors between keyframes that no landmark connects, where the scene was lost.
    void add_odometry(ceres::Problem& problem);
    void add_priors(ceres::Problem& problem, const FreeUnknowns& free);
    // Returns false if the information matrix cannot be factorised.
    bool find_sigmas(ceres::Problem& problem, const FreeUnknowns& free);
    // Returns how far the unknowns moved, RMS of their sigmas; the largest of IMU rotation, time
    // offset, lenses and readout time.
    double moved_sigmas(const CalibrationUnknowns& before) const;
    LensReprojection::Shift shift_of(const std::array<camera::RectifiedLens, 2>& lenses,
                                     const Eigen::Vector3d& measured_px) const;
    Eigen::Vector3d shift_by_readout_px_s(const types::Landmark& landmark,
                                          const types::LandmarkObservation& seen) const;
    std::array<camera::RectifiedLens, 2> lenses() const;
    // All but the landmarks; the calibration unknowns come first.
    std::vector<double*> kept_blocks();
    double* q(State& state) { return state.q_world_body.coeffs().data(); }

    const types::Track& track_;
    const types::Recording& recording_;
    const imu::InertialPrior& inertial_;
    LensChanges prior_sigmas_;
    camera::RollingShutter shutter_;
    std::vector<std::optional<camera::CameraMotion>> motions_;  // at the keyframes
    std::vector<State> states_;
    std::vector<types::Landmark> landmarks_;
    std::size_t stride_ = 1;
    CalibrationUnknowns unknowns_;
    CalibrationSigmas sigmas_;
    ceres::EigenQuaternionManifold rotation_;
    ceres::HuberLoss loss_;
    ceres::HuberLoss lens_loss_;
};

}  // namespace divemesh::calibration
