#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "tests/temporary_folder.hpp"
#include "tests/worker/fusion/synthetic_views.hpp"
#include "worker/fusion/fusion_volume.hpp"
#include "worker/fusion/level_plan.hpp"
#include "worker/mesh/extract_surface.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::fusion {
namespace {

ReconstructionOptions options_with(int num_threads) {
    ReconstructionOptions options;
    options.num_threads = num_threads;
    return options;
}

types::Mesh surface_of(const Volume& volume, const ReconstructionOptions& options) {
    return mesh::extract_surface(volume, options.mesher, options.num_threads).mesh;
}

std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

// A floor that two rows of views see from 0.7 m and, farther on, from 2.8 m.
class FloorSeenNearAndFar : public testing::Test {
protected:
    static constexpr double kNear_m = 0.7, kFar_m = 2.8, kSigma_px = 0.1;

    static std::vector<Eigen::Isometry3d> poses(double height_m, double first_x_m) {
        std::vector<Eigen::Isometry3d> poses;
        for (int i = 0; i < 6; ++i) {
            const double x_m = first_x_m + 0.05 * i;
            poses.push_back(look_at({x_m, 0.01, height_m}, {x_m, 0.0, 0.0}));
        }
        return poses;
    }

    // Fuses as if the median depth were that of the near views, or of the far ones.
    static std::unique_ptr<Volume> fuse(const SceneDistance& scene,
                                        const std::vector<Eigen::Isometry3d>& poses,
                                        double median_depth_m) {
        const ReconstructionOptions options = options_with(1);
        VolumeSettings settings = choose_settings(small_rig(), options, median_depth_m);
        LevelPlanner planner(small_rig(), settings.voxel_m, median_depth_m);
        std::vector<SyntheticView> views;
        for (const auto& pose : poses) {
            views.push_back(render_view(scene,
                                        small_rig(),
                                        pose,
                                        {.sigma_px = kSigma_px, .stated_sigma_px = kSigma_px},
                                        static_cast<unsigned>(views.size())));
            planner.add(pose, views.back().images.depth.disparity_px, 1);
        }
        LevelPlanner::Planned planned = planner.finish();
        settings.voxel_m = planned.voxel_m;
        settings.levels = std::make_shared<LevelPlan>(std::move(planned.plan));
        settings.max_depth_m = 4.0;
        auto volume = make_volume(settings, options);
        for (const SyntheticView& view : views) volume->integrate(view.keyframe, view.images);
        return volume;
    }

    static double median_error_near(const Volume& volume) {
        std::vector<double> errors;
        for (const auto& vertex : surface_of(volume, options_with(1)).vertices)
            if (std::abs(vertex.x()) < 0.2F && std::abs(vertex.y()) < 0.2F)
                errors.push_back(std::abs(bump_on_floor(vertex.cast<double>())));
        EXPECT_GT(errors.size(), 1000U);
        return stats::upper_median(errors);
    }
};

TEST_F(FloorSeenNearAndFar, IsAsGoodNearAsIfNothingHadBeenSeenFromFar) {
    auto both = poses(kNear_m, -0.1);
    const auto near_alone = fuse(bump_on_floor, both, kNear_m);
    for (const auto& pose : poses(kFar_m, 0.3)) both.push_back(pose);
    for (const double median_depth_m : {kNear_m, kFar_m}) {
        const auto volume = fuse(bump_on_floor, both, median_depth_m);
        EXPECT_GE(volume->settings().levels->num_levels(), 3);
        EXPECT_NEAR(volume->voxel_m(), near_alone->voxel_m(), 0.5 * near_alone->voxel_m());
        // Flat ground is smoothed to a tenth of a millimetre, more than any real one.
        EXPECT_LT(median_error_near(*volume),
                  1.1 * median_error_near(*near_alone) + 0.02 * near_alone->voxel_m());
    }
}

// The far views are twelve times as far away as the median depth, where 0.1 px are 1.5 % of the
// depth.
TEST_F(FloorSeenNearAndFar, IsSurfaceFarFromTheMedianDepthToo) {
    const types::RectifiedRig rig = small_rig();
    const double far_m = 0.015 * rig.focal_px * rig.baseline_m / kSigma_px;
    const double near_m = far_m / 12.0;
    auto both = poses(near_m, -0.1);
    for (const auto& pose : poses(far_m, 0.0)) both.push_back(pose);
    const SceneDistance floor = [](const Eigen::Vector3d& p) { return p.z(); };
    const types::Mesh mesh = surface_of(*fuse(floor, both, near_m), options_with(1));
    // Beyond what the near views see.
    const double near_half_m = near_m * 0.5 * rig.width_px / rig.focal_px + 0.2;
    std::vector<double> heights_m;
    for (const auto& vertex : mesh.vertices)
        if (std::abs(vertex.x()) > near_half_m) heights_m.push_back(std::abs(vertex.z()));
    ASSERT_GT(heights_m.size(), 200U);
    EXPECT_LT(stats::upper_median(heights_m), 0.015 * far_m);
}

TEST_F(FloorSeenNearAndFar, IsOneSurfaceWithoutCracks) {
    auto all = poses(kNear_m, -0.1);
    for (const auto& pose : poses(kFar_m, 0.0)) all.push_back(pose);
    const SceneDistance waves = [](const Eigen::Vector3d& p) {
        return 0.9 * (p.z() - 0.06 * std::sin(4.0 * p.x()) * std::cos(4.0 * p.y()));
    };
    const types::Mesh mesh = surface_of(*fuse(waves, all, kFar_m), options_with(1));
    EXPECT_EQ(mesh::find_components(mesh).area_m2.size(), 1U);
    EXPECT_EQ(mesh::check_topology(mesh).num_nonmanifold_edges, 0);
    // Each edge inside the image of all views is a side of two triangles.
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
    std::size_t num_inside = 0;
    for (const auto& [edge, num] : sides) {
        const Eigen::Vector3f& p = mesh.vertices[edge.first];
        if (std::abs(p.x()) > 1.0F || std::abs(p.y()) > 0.75F) continue;
        EXPECT_EQ(num, 2) << p.transpose();
        ++num_inside;
    }
    EXPECT_GT(num_inside, 10'000U);
    const auto [narrowest, widest] = std::minmax_element(mesh.voxel_m.begin(), mesh.voxel_m.end());
    EXPECT_GE(*widest, 4.0F * *narrowest);
}

TEST_F(FloorSeenNearAndFar, IsTheSameFromItsFileAndWithSpilling) {
    auto all = poses(kNear_m, -0.1);
    for (const auto& pose : poses(kFar_m, 0.0)) all.push_back(pose);
    const auto volume = fuse(bump_on_floor, all, kFar_m);
    const TemporaryFolder folder;
    volume->save(folder / "volume");
    const auto loaded = load_volume(folder / "volume", {folder.path(), 1});
    loaded->trim();
    EXPECT_LT(loaded->memory_bytes(), volume->memory_bytes());
    loaded->save(folder / "again");
    EXPECT_EQ(bytes_of(folder / "again"), bytes_of(folder / "volume"));
    const types::Mesh mesh = surface_of(*volume, options_with(1));
    const types::Mesh same = surface_of(*loaded, options_with(2));
    EXPECT_EQ(same.vertices, mesh.vertices);
    EXPECT_EQ(same.triangles, mesh.triangles);
    std::vector<Eigen::Vector3d> points;
    for (const auto& vertex : mesh.vertices) points.push_back(vertex.cast<double>());
    std::vector<std::uint8_t> confirmed(points.size());
    loaded->confirm(points, confirmed.data());
    EXPECT_GT(std::count(confirmed.begin(), confirmed.end(), 1),
              0.97 * static_cast<double>(points.size()));
}

}  // namespace
}  // namespace divemesh::fusion
