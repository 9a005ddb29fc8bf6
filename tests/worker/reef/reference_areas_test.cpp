#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/paths.hpp"
#include "worker/io/ply.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/rugosity.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {
namespace {

using nlohmann::json;

// reference.ply is the surface that the cameras saw, while the published metrics are those of the
// whole surface. An area counts by the share of it that the samples of reference.ply cover.
class ReferenceAreas : public testing::Test {
protected:
    void SetUp() override {
        if (!std::filesystem::exists(shared_data("barge") / "reference.ply"))
            GTEST_SKIP() << "no shared data";
    }

    static HeightGrid grid_of(const types::Mesh& mesh, const json& patch, double spacing_m) {
        Area area;
        area.name = patch["name"];
        const auto vector = [](const json& v) {
            return Eigen::Vector3d(v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
        };
        for (const json& corner : patch["corners_world"]) area.points.push_back(vector(corner));
        area.normal = vector(patch["normal_world"]).normalized();
        const AreaPlane plane = plane_of(area);
        const SurfacePatch cut = cut_patch(mesh, plane, 0.01);
        return sample_heights(cut.vertices, cut.triangles, grid_over(plane.outline, spacing_m));
    }

    static json patch_of(const std::string& dive, std::size_t index) {
        std::ifstream file(shared_data(dive) / "reference_area.json");
        return json::parse(file)["patches"][index];
    }
};

TEST_F(ReferenceAreas, TheDeckHasItsPublishedRugosity) {
    const types::Mesh mesh = io::read_ply(shared_data("barge") / "reference.ply");
    const json deck = patch_of("barge", 0);
    for (const int mm : {5, 10, 20}) {
        const double truth = deck["rugosity_dem_" + std::to_string(mm) + "mm"];
        EXPECT_NEAR(rugosity(grid_of(mesh, deck, 1e-3 * mm)).value(), truth, 0.002 * truth) << mm;
    }
    EXPECT_NEAR(rugosity(grid_of(mesh, deck, 0.05)).value(), 1.207, 0.002);
}

TEST_F(ReferenceAreas, TheFloorOfTheTankIsFlat) {
    const types::Mesh mesh = io::read_ply(shared_data("tank") / "reference.ply");
    EXPECT_NEAR(rugosity(grid_of(mesh, patch_of("tank", 0), 0.01)).value(), 1.0, 1e-6);
}

}  // namespace
}  // namespace divemesh::reef
