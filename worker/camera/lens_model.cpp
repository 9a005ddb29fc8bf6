#include "worker/camera/lens_model.hpp"

#include "worker/camera/double_sphere_lens.hpp"
#include "worker/camera/equidistant_lens.hpp"
#include "worker/camera/extended_unified_lens.hpp"
#include "worker/camera/omnidirectional_lens.hpp"
#include "worker/camera/pinhole_lens.hpp"
#include "worker/camera/radial_tangential_lens.hpp"
#include "worker/camera/rational_lens.hpp"

namespace divemesh::camera {
namespace {

constexpr std::array kLensModels = {kPinholeLens,
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

}  // namespace

std::span<const LensModel> lens_models() { return kLensModels; }

const LensModel& lens_model(types::Distortion distortion) {
    return kLensModels[static_cast<std::size_t>(distortion)];
}

}  // namespace divemesh::camera
