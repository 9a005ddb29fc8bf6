#include "worker/compare/co_register.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <iostream>
#include <string>

#include "schemas/error.hpp"
#include "tests/synthetic/rough_ground.hpp"

namespace divemesh::compare {
namespace {

using synthetic::ground_mesh;
using synthetic::HeightOf;
using synthetic::moved;
using synthetic::rough_ground;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kStep_m = 0.02;
constexpr double kNoise_m = 0.003;

// Raises a fifth of the ground by 8 cm.
HeightOf with_a_fifth_raised(const HeightOf& ground) {
    return [ground](double x, double y) { return ground(x, y) + (x > 1.02 ? 0.08 : 0.0); };
}

Eigen::Isometry3d pose(double heading, double tilt, const Eigen::Vector3d& shift) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = (Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
    T.translation() = shift;
    return T;
}

CoRegistration registered(const types::Mesh& a, const types::Mesh& b) {
    return co_register(a, b, {.spacing_m = kStep_m, .num_threads = 2}, {});
}

TEST(CoRegister, FindsAnyHeadingThoughAFifthOfTheGroundHasChanged) {
    const HeightOf ground = rough_ground(1);
    const types::Mesh a = ground_mesh(ground, 1.7, 1.3, kStep_m, kNoise_m, 1);
    for (const double heading : {0.4, 2.9}) {
        const Eigen::Isometry3d T_b_a = pose(heading, 0.005, {3.0, -2.0, 0.7});
        const types::Mesh b =
            moved(ground_mesh(with_a_fifth_raised(ground), 1.7, 1.3, kStep_m, kNoise_m, 2), T_b_a);
        const CoRegistration fit = registered(a, b);
        const Eigen::Isometry3d off = fit.T_a_b * T_b_a;
        const double rotation_deg = 57.3 * Eigen::AngleAxisd(off.linear()).angle();
        std::cout << "off by " << rotation_deg << " deg, " << 1e3 * off.translation().norm()
                  << " mm\n";
        EXPECT_LT(rotation_deg, 0.1);
        EXPECT_LT(off.translation().norm(), 0.002);
        EXPECT_GT(fit.overlap, 0.9);
        EXPECT_NEAR(fit.agreement, 0.8, 0.05);
    }
}

// Returns the fit of ground that lies where it should.
std::optional<CoRegistration> icp(const types::Mesh& a, const types::Mesh& b) {
    const std::vector<float> unknown;
    const PointGrid grid_a(a.vertices, 0.06F);
    const PointGrid grid_b(b.vertices, 0.06F);
    return point_to_plane_icp({a.vertices, a.normals, unknown, grid_a},
                              {b.vertices, b.normals, unknown, grid_b},
                              Eigen::Isometry3d::Identity(),
                              {.num_threads = 2});
}

TEST(CoRegister, ItsUncertaintyHoldsOverManyDraws) {
    const HeightOf ground = rough_ground(2);
    int num_within = 0;
    constexpr int kDraws = 30;
    for (int draw = 0; draw < kDraws; ++draw) {
        const auto seed = static_cast<unsigned>(10 + 2 * draw);
        const types::Mesh a = ground_mesh(ground, 1.2, 1.0, kStep_m, kNoise_m, seed);
        const types::Mesh b = ground_mesh(ground, 1.2, 1.0, kStep_m, kNoise_m, seed + 1);
        const auto fit = icp(a, b);
        ASSERT_TRUE(fit);
        const Eigen::Vector3d off = fit->T_a_b * fit->pivot - fit->pivot;
        num_within +=
            std::abs(off.z()) <= 1.96 * fit->sigma_m(fit->pivot, Eigen::Vector3d::UnitZ());
    }
    EXPECT_GE(num_within, 26);  // 95 % of 30 is 28.5; fewer than 26 occur in 1 % of all trials
}

TEST(CoRegister, RoughGroundShowsByHowMuchOneSurfaceIsLarger) {
    for (unsigned draw = 0; draw < 3; ++draw) {
        const HeightOf ground = rough_ground(40 + draw);
        const types::Mesh a = ground_mesh(ground, 1.2, 1.0, kStep_m, kNoise_m, 2 * draw);
        types::Mesh b = ground_mesh(ground, 1.2, 1.0, kStep_m, kNoise_m, 2 * draw + 1);
        for (Eigen::Vector3f& p : b.vertices) p *= 1.01F;
        const auto fit = icp(a, b);
        ASSERT_TRUE(fit && fit->scale);
        EXPECT_NEAR(fit->scale->value, 0.01, 0.001);
        EXPECT_LT(fit->scale->sigma, 0.001);
    }
}

TEST(CoRegister, RefusesAnotherPlace) {
    const types::Mesh a = ground_mesh(rough_ground(3), 1.7, 1.3, kStep_m, kNoise_m, 1);
    for (const unsigned place : {4U, 5U, 6U}) {
        const types::Mesh b = ground_mesh(rough_ground(place), 1.7, 1.3, kStep_m, kNoise_m, 2);
        try {
            const CoRegistration fit = registered(a, b);
            FAIL() << "laid place " << place << " over place 3, agreement " << fit.agreement;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Conflict) << error.what();
        }
    }
}

TEST(CoRegister, IcpSaysWhetherItConverged) {
    const HeightOf ground = rough_ground(1);
    const std::vector<float> unknown;
    const types::Mesh a = ground_mesh(ground, 1.2, 1.0, kStep_m, kNoise_m, 1);
    const types::Mesh b = moved(ground_mesh(ground, 1.2, 1.0, kStep_m, kNoise_m, 2),
                                pose(0.02, 0.0, {0.04, -0.03, 0.02}));
    const PointGrid grid_a(a.vertices, 0.06F);
    const PointGrid grid_b(b.vertices, 0.06F);
    const auto fit = [&](int max_rounds) {
        return point_to_plane_icp({a.vertices, a.normals, unknown, grid_a},
                                  {b.vertices, b.normals, unknown, grid_b},
                                  Eigen::Isometry3d::Identity(),
                                  {.max_rounds = max_rounds, .num_threads = 2});
    };
    const auto stopped = fit(2);
    const auto done = fit(IcpOptions{}.max_rounds);
    ASSERT_TRUE(stopped && done);
    EXPECT_TRUE(stopped->outcome.still_moving()) << stopped->outcome.last_step_sigmas;
    EXPECT_EQ(stopped->outcome.num_iterations, 2);
    EXPECT_FALSE(done->outcome.still_moving()) << done->outcome.last_step_sigmas;
    EXPECT_LT(done->outcome.final_cost, done->outcome.initial_cost);
}

// If the stated uncertainty of surfaces is centimetres, large parts of any ground lie within it.
TEST(CoRegister, RefusesAnotherPlaceAlsoWhereSurfacesAreNotWellKnown) {
    for (const unsigned place : {22U, 30U, 42U}) {
        types::Mesh a = ground_mesh(rough_ground(place), 1.7, 1.3, kStep_m, kNoise_m, 1);
        types::Mesh b = ground_mesh(rough_ground(place + 1), 1.2, 1.0, kStep_m, kNoise_m, 2);
        for (types::Mesh* mesh : {&a, &b}) mesh->sigma_m.assign(mesh->vertices.size(), 0.02F);
        try {
            const CoRegistration fit = registered(a, b);
            ADD_FAILURE() << "laid place " << place + 1 << " over " << place << ", agreement "
                          << fit.agreement;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Conflict) << error.what();
        }
    }
}

TEST(CoRegister, FindsLowGroundOfWhichEachSurfaceShowsTheShape) {
    const auto low = [ground = rough_ground(9)](double x, double y) { return 0.4 * ground(x, y); };
    const Eigen::Isometry3d T_b_a = pose(1.0, 0.0, {0.5, 0.2, -0.1});
    const types::Mesh later = moved(ground_mesh(low, 1.7, 1.3, kStep_m, kNoise_m, 2), T_b_a);
    const CoRegistration fit = registered(ground_mesh(low, 1.7, 1.3, kStep_m, kNoise_m, 1), later);
    EXPECT_LT((fit.T_a_b * T_b_a).translation().norm(), 0.005);
}

// Returns why two surfaces are not aligned; empty if they are.
std::string refusal(const types::Mesh& a, const types::Mesh& b, int max_icp_rounds) {
    try {
        co_register(
            a, b, {.spacing_m = kStep_m, .num_threads = 2, .max_icp_rounds = max_icp_rounds}, {});
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Conflict);
        return error.what();
    }
    return "";
}

constexpr int kEnough = IcpOptions{}.max_rounds;

TEST(CoRegister, RefusesGroundWithoutShapeAndWithoutImages) {
    const HeightOf flat = [](double, double) { return 0.0; };
    const types::Mesh a = ground_mesh(flat, 1.0, 1.0, kStep_m, kNoise_m, 1);
    const types::Mesh b = ground_mesh(flat, 1.0, 1.0, kStep_m, kNoise_m, 2);
    EXPECT_THAT(refusal(a, b, kEnough),
                HasSubstr("no image features match, and the ground is too flat"));
}

TEST(CoRegister, RefusesSurfacesOfWhichIcpStillMovesOne) {
    const HeightOf ground = rough_ground(1);
    const types::Mesh a = ground_mesh(ground, 1.7, 1.3, kStep_m, kNoise_m, 1);
    const types::Mesh b = moved(ground_mesh(ground, 1.7, 1.3, kStep_m, kNoise_m, 2),
                                pose(0.42, 0.0, {0.05, -0.07, 0.02}));
    EXPECT_EQ(refusal(a, b, kEnough), "");
    EXPECT_THAT(refusal(a, b, 1), HasSubstr("after 1 rounds of ICP"));
}

// Colours each vertex by a pattern of the ground that a feature detector finds again.
void paint(types::Mesh& mesh) {
    const HeightOf pattern = rough_ground(7);
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
        const Eigen::Vector3d p = vertex.cast<double>();
        const double grey = 128.0 + 400.0 * pattern(6.0 * p.x(), 6.0 * p.y());
        mesh.colors.emplace_back();
        mesh.colors.back().fill(static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0)));
    }
}

TEST(CoRegister, SaysThatFeaturesMatchWhereTheyDoAndTheGroundHasChanged) {
    const HeightOf flat = [](double, double) { return 0.0; };
    const HeightOf half_raised = [](double x, double) { return x > 0.0 ? 0.2 : 0.0; };
    types::Mesh a = ground_mesh(flat, 1.0, 1.0, kStep_m, kNoise_m, 1);
    types::Mesh same = ground_mesh(flat, 1.0, 1.0, kStep_m, kNoise_m, 2);
    types::Mesh changed = ground_mesh(half_raised, 1.0, 1.0, kStep_m, kNoise_m, 2);
    for (types::Mesh* mesh : {&a, &same, &changed}) paint(*mesh);
    const Eigen::Isometry3d T_b_a = pose(0.3, 0.0, {0.2, 0.1, 0.0});
    EXPECT_EQ(refusal(a, moved(same, T_b_a), kEnough), "");
    EXPECT_THAT(refusal(a, moved(changed, T_b_a), kEnough),
                AllOf(HasSubstr("image features match, but there only"),
                      Not(HasSubstr("no image features"))));
}

}  // namespace
}  // namespace divemesh::compare
