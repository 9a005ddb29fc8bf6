#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "worker/texture/face_candidates.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::texture {

// With fewer colours none can be called wrong.
inline constexpr std::size_t kMinJudgedViews = 3;

using LogColor = Eigen::Array3f;  // b g r, natural logarithm

// Why keyframes see one surface in different colours: each has a gain (exposure, lamps, the sun),
// and water takes light with range. All of the logarithm of the colour.
struct WaterLight {
    std::vector<LogColor> gains;                    // one per keyframe
    LogColor attenuation_per_m = LogColor::Zero();  // of the dive
    LogColor sigma = LogColor::Zero();              // of a triangle's colour after both
};

// A mesh with the keyframes that see it.
struct SeenMesh {
    const types::Mesh& mesh;
    const std::vector<types::Keyframe>& keyframes;
    const FaceCandidates& candidates;

    float range_m(std::size_t face, const Candidate& candidate) const;
};

// How far the colour of each candidate of a triangle is from the median of all, without gain and
// attenuation.
using ColorResiduals = std::array<LogColor, FaceCandidates::kMaxViews>;
ColorResiduals color_residuals(const SeenMesh& seen, const WaterLight& light, std::size_t face);

// Fits the light to triangles that three or more keyframes see, spread over the mesh. All estimates
// are medians, so that what swims before the cameras changes them little.
WaterLight fit_water_light(const SeenMesh& seen, int num_threads);

}  // namespace divemesh::texture
