#include "worker/texture/water_light.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/texture/square_mesh.hpp"

namespace divemesh::texture {
namespace {

// The fitted function adds 8 levels to the colours before it takes logarithms; so does this truth.
std::uint8_t level(double brightness) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(brightness - 8.0, 0.0, 255.0)));
}

TEST(WaterLight, FindsGainsAndAttenuationAmongOutliers) {
    const types::Mesh mesh = square_mesh(2.0F, 40);
    const LogColor attenuation_per_m(0.1F, 0.15F, 0.4F);
    const std::vector<float> gains = {0.0F, 0.3F, -0.2F, 0.1F, 0.0F};
    std::vector<types::Keyframe> keyframes(gains.size());
    for (std::size_t i = 0; i < keyframes.size(); ++i)
        keyframes[i].T_world_cam.translation() =
            Eigen::Vector3d(0.5 * static_cast<double>(i) - 1.0, 0.0, i % 2 == 0 ? 1.0 : 1.3);
    FaceCandidates candidates(mesh.triangles.size());
    const SeenMesh seen{mesh, keyframes, candidates};
    for (std::size_t face = 0; face < mesh.triangles.size(); ++face)
        for (std::uint16_t view = 0; view < gains.size(); ++view) {
            Candidate candidate{view, 1000};
            const float range_m = seen.range_m(face, candidate);
            const double albedo = face % 2 == 0 ? 200.0 : 120.0;
            for (int channel = 0; channel < 3; ++channel)
                candidate.bgr[channel] =
                    level(albedo * std::exp(static_cast<double>(
                                       gains[view] - attenuation_per_m[channel] * range_m)));
            if (view == 2 && face % 5 == 0) candidate.bgr = {10, 200, 10};
            candidates.add(face, candidate);
        }
    const WaterLight light = fit_water_light(seen, 2);
    for (int channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(light.attenuation_per_m[channel], attenuation_per_m[channel], 0.02F);
        for (std::size_t view = 1; view < gains.size(); ++view)
            EXPECT_NEAR(light.gains[view][channel] - light.gains[0][channel],
                        gains[view] - gains[0],
                        0.03F);
        EXPECT_LT(light.sigma[channel], 0.03F);
    }
}

}  // namespace
}  // namespace divemesh::texture
