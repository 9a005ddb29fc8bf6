#include "worker/calibration/calibration_priors.hpp"

#include <algorithm>
#include <cmath>

namespace divemesh::calibration {
namespace {

constexpr double kFocalSigma = 0.0015;        // relative
constexpr double kCentreSigma = 1.0 / 640.0;  // of the width of the image
constexpr double kDistortionSigma = 0.02;
constexpr double kDistortionShare = 0.15;  // of the coefficient, if that is larger

}  // namespace

LensChanges joined(const std::array<types::LensChange, 2>& lenses) {
    LensChanges changes;
    changes << lenses[0].values, lenses[1].values;
    return changes;
}

LensChanges lens_prior_sigmas(const types::Rig& rig, const types::RigAlignment& alignment) {
    const double shift_px =
        alignment.applied ? alignment.change.values[types::RigChange::kCentreDown] : 0.0;
    LensChanges sigmas;
    for (Eigen::Index side = 0; side < 2; ++side) {
        const types::Camera& camera = side == 0 ? rig.cam0 : rig.cam1;
        const auto& k = camera.distortion_coefficients;
        const double centre_px = kCentreSigma * camera.width_px;
        const double yaw_px = side == 0 ? 0.0 : kStereoRotationSigma * camera.fx_px;
        sigmas.segment<types::LensChange::kSize>(types::LensChange::kSize * side) << kFocalSigma,
            std::hypot(centre_px, yaw_px), std::hypot(centre_px, shift_px),
            std::max(kDistortionSigma, kDistortionShare * std::abs(k[0])),
            std::max(kDistortionSigma, kDistortionShare * std::abs(k[1]));
    }
    return sigmas;
}

}  // namespace divemesh::calibration
