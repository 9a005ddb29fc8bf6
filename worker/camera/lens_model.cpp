#include "worker/camera/lens_model.hpp"

#include "worker/camera/lens_table.hpp"

namespace divemesh::camera {

std::span<const LensModel> lens_models() { return kLensModels; }

const LensModel& lens_model(types::Distortion distortion) {
    return kLensModels[static_cast<std::size_t>(distortion)];
}

}  // namespace divemesh::camera
