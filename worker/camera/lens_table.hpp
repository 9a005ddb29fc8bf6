#pragma once

#include "worker/camera/double_sphere_lens.hpp"
#include "worker/camera/equidistant_lens.hpp"
#include "worker/camera/extended_unified_lens.hpp"
#include "worker/camera/omnidirectional_lens.hpp"
#include "worker/camera/pinhole_lens.hpp"
#include "worker/camera/radial_tangential_lens.hpp"
#include "worker/camera/rational_lens.hpp"

// The table of the lens models, for what has to know them when it is compiled; all else includes
// lens_model.hpp.
namespace divemesh::camera {

inline constexpr std::array kLensModels = {kPinholeLens,
                                           kRadialTangentialLens,
                                           kEquidistantLens,
                                           kRationalLens,
                                           kOmnidirectionalLens,
                                           kDoubleSphereLens,
                                           kExtendedUnifiedLens};

constexpr bool are_in_order() {
    for (std::size_t i = 0; i < kLensModels.size(); ++i)
        if (static_cast<std::size_t>(kLensModels[i].distortion) != i) return false;
    return true;
}
static_assert(are_in_order(), "the table has the order of types::Distortion");

// Does what LensModel::distort does, for any kind of numbers: coefficients are `k[0]` and on.
template <types::Distortion kDistortion, typename Coefficients, typename T>
Eigen::Vector2<T> distort(const Coefficients& k, const Eigen::Vector2<T>& n) {
    using types::Distortion;
    if constexpr (kDistortion == Distortion::None) return keep_straight(k, n);
    if constexpr (kDistortion == Distortion::RadialTangential)
        return distort_radial_tangential(k, n);
    if constexpr (kDistortion == Distortion::Equidistant) return distort_equidistant(k, n);
    if constexpr (kDistortion == Distortion::Rational) return distort_rational(k, n);
    if constexpr (kDistortion == Distortion::Omnidirectional) return distort_omnidirectional(k, n);
    if constexpr (kDistortion == Distortion::DoubleSphere) return distort_double_sphere(k, n);
    if constexpr (kDistortion == Distortion::ExtendedUnified) return distort_extended_unified(k, n);
}

}  // namespace divemesh::camera
