#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "worker/optimisation/irls_outcome.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/rig_alignment.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/stereo_match.hpp"

namespace divemesh::calibration {

// The row errors of imperfect lens models: a polynomial of degree 2 and 3 of the right pixel that
// is added to its row. Without these terms and their priors, errors of the lenses would be
// attributed to the pose of the rig.
constexpr int kNumLensTerms = 7;
using LensTerms = Eigen::Matrix<double, kNumLensTerms, 1>;

// The unknowns: the change of the rig, then the coefficients of the lens terms, px.
constexpr int kNumEpipolarUnknowns = types::RigChange::kSize + kNumLensTerms;
using EpipolarUnknowns = Eigen::Matrix<double, kNumEpipolarUnknowns, 1>;
using EpipolarCovariance = Eigen::Matrix<double, kNumEpipolarUnknowns, kNumEpipolarUnknowns>;

struct EpipolarSolution {
    EpipolarUnknowns values = EpipolarUnknowns::Zero();
    EpipolarCovariance covariance = EpipolarCovariance::Zero();
    double error_px = 0.0;        // robust standard deviation of the residuals
    std::vector<double> weights;  // of the matches, 0 (outlier) to 1
    types::SolverOutcome outcome;
};

// The least squares of the epipolar errors of matches, px:
//
//     e = f b . (l x R r) - c . m      l, r: rays of the left and the right pixel, z = 1
//
// with R the rotation (pitch, yaw, roll about the axes of the right camera) and b = (1, down,
// forward) the direction of the baseline in the frame of the rectified left camera (Longuet-Higgins
// 1981), and c . m the lens terms. With the stated calibration e is the row of the left pixel minus
// that of the right one. Outliers lose their weight (Tukey's biweight).
class EpipolarProblem {
public:
    using Held = std::array<bool, kNumEpipolarUnknowns>;  // true: stays as stated

    EpipolarProblem(const types::Rig& rig,
                    const types::RectifiedRig& rectified,
                    const types::StereoMatches& matches);

    // Returns the maximum a posteriori, with priors as wide as a rig may have been knocked by. That
    // of the lens terms is as wide as they are found to be (empirical Bayes), so that good lenses
    // do not blur the rest. The covariance counts errors that the matches of one pair share. The
    // outcome is that of all rounds: converged if neither the last step nor the last change of the
    // lens terms' prior moves the unknowns.
    EpipolarSolution solve(const Held& held) const;
    // Returns the errors of all matches.
    std::vector<double> errors_px(const EpipolarUnknowns& values) const;

private:
    struct Sample {
        int frame_index = 0;
        Eigen::Vector3d left_ray;
        Eigen::Vector3d right_ray;
        Eigen::Vector3d right_by_focal;        // d(right ray)/d(focal length), of the same true ray
        Eigen::Vector3d right_by_centre_down;  // and by the principal point
        LensTerms lens_terms;
    };
    struct Residual {
        double error_px = 0.0;
        EpipolarUnknowns gradient;
    };
    struct NormalEquations {
        EpipolarCovariance information = EpipolarCovariance::Zero();
        EpipolarUnknowns gradient = EpipolarUnknowns::Zero();
        EpipolarCovariance between_pairs = EpipolarCovariance::Zero();
    };

    // The right camera by values of the unknowns, relative to the rectified left one.
    struct Moved {
        Eigen::Matrix3d R;
        Eigen::Vector3d baseline;
        EpipolarUnknowns values;
    };
    Moved moved(const EpipolarUnknowns& values) const;
    static Eigen::Vector3d right_ray(const Sample& sample, const Moved& rig);
    // `across` is the product of the left ray and the right one.
    double error_px(const Sample& sample, const Moved& rig, const Eigen::Vector3d& across) const;
    Residual residual(const Sample& sample, const Moved& rig) const;
    // A solution under one prior of the lens terms.
    struct Solved {
        EpipolarSolution solution;
        EpipolarCovariance information;
        optimisation::IrlsSteps steps;
    };
    Solved solve(const Held& held, double lens_sigma_px) const;
    // Returns the RMS of a step over the unknowns that are not held, in their sigmas.
    static double step_sigmas(const EpipolarUnknowns& step,
                              const EpipolarCovariance& information,
                              const Held& held);
    // Returns the robust loss of errors at a scale, with that of the prior.
    double cost(const EpipolarUnknowns& values,
                double error_px,
                const EpipolarUnknowns& prior_sigmas) const;
    NormalEquations equations(const EpipolarSolution& at,
                              const Held& held,
                              const EpipolarUnknowns& prior_sigmas) const;

    double focal_px_ = 0.0;
    Eigen::Matrix3d R_rectified_right_;
    std::vector<Sample> samples_;  // those of a pair follow each other
};

}  // namespace divemesh::calibration
