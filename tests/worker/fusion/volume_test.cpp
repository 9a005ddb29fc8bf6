#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <string>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/fusion/synthetic_views.hpp"
#include "worker/fusion/fusion_volume.hpp"
#include "worker/fusion/unshared_depth.hpp"
#include "worker/fusion/voxel_size.hpp"
#include "worker/mesh/extract_surface.hpp"
#include "worker/mesh/mesh_borders.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::fusion {
namespace {

constexpr double kVoxel_m = 0.015;

ReconstructionOptions options_for(const std::string& fusion, int num_threads = 1) {
    ReconstructionOptions options;
    options.fusion = fusion;
    options.voxel_m = kVoxel_m;
    options.max_depth_m = 4.0;
    options.num_threads = num_threads;
    return options;
}

std::unique_ptr<Volume> fuse_views(const SceneDistance& scene,
                                   const std::vector<Eigen::Isometry3d>& poses,
                                   const ReconstructionOptions& options,
                                   const ViewNoise& noise = {}) {
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    unsigned seed = 0;
    for (const auto& pose : poses) {
        const auto view = render_view(scene, small_rig(), pose, noise, ++seed);
        volume->integrate(view.keyframe, view.images);
    }
    return volume;
}

std::vector<double> distances_from(const SceneDistance& scene, const types::Mesh& mesh) {
    std::vector<double> distances;
    for (const auto& vertex : mesh.vertices)
        distances.push_back(std::abs(scene(vertex.cast<double>())));
    std::sort(distances.begin(), distances.end());
    return distances;
}

std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

types::Mesh surface_of(const Volume& volume, const ReconstructionOptions& options) {
    return mesh::extract_surface(volume, options.mesher, options.num_threads).mesh;
}

class BothVolumes : public testing::TestWithParam<std::string> {};

TEST_P(BothVolumes, ExactDepthOfAnAnalyticSceneComesOutToAFifthOfAVoxel) {
    const auto options = options_for(GetParam());
    const auto volume = fuse_views(bump_on_floor, views_from_above(8, 1.2), options);
    const types::Mesh mesh = surface_of(*volume, options);
    const auto distances = distances_from(bump_on_floor, mesh);
    ASSERT_GT(distances.size(), 2000U);
    EXPECT_LT(stats::upper_median(distances), 0.2 * kVoxel_m);
    EXPECT_LT(distances[distances.size() * 95 / 100], 0.7 * kVoxel_m);
    EXPECT_EQ(mesh::check_topology(mesh).num_misoriented_edges, 0);
    EXPECT_EQ(mesh::check_topology(mesh).num_nonmanifold_edges, 0);
}

// The right half of the image is too far, the lowest quarter is measured to 6 px.
TEST_P(BothVolumes, CountTheDepthThatMakesNoSurface) {
    auto options = options_for(GetParam());
    options.max_depth_m = 2.0;
    const auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    const cv::Size size(small_rig().width_px, small_rig().height_px);
    types::KeyframeImages images;
    images.left_color = cv::Mat(size, CV_8UC3, cv::Scalar::all(0));
    images.depth.disparity_px = cv::Mat(size, CV_32F, cv::Scalar(small_rig().disparity_px(1.0)));
    images.depth.sigma_disparity_px = cv::Mat(size, CV_32F, cv::Scalar(0.1));
    images.depth.disparity_px.colRange(size.width / 2, size.width)
        .setTo(small_rig().disparity_px(3.0));
    images.depth.sigma_disparity_px.rowRange(size.height * 3 / 4, size.height).setTo(6.0);
    volume->integrate({}, images);
    const FusedPixels& pixels = volume->fused_pixels();
    ASSERT_GT(pixels.num, 2'000);
    const auto num = static_cast<double>(pixels.num);
    EXPECT_NEAR(static_cast<double>(pixels.num_too_far) / num, 0.5, 0.05);
    EXPECT_NEAR(
        static_cast<double>(pixels.num_too_vague) / num, GetParam() == "tsdf" ? 0.125 : 0.0, 0.02);
}

TEST_P(BothVolumes, ColoursLieWhereTheCamerasSawThem) {
    const auto options = options_for(GetParam());
    const auto volume = fuse_views(bump_on_floor, views_from_above(6, 1.2), options);
    const types::Mesh mesh = surface_of(*volume, options);
    ASSERT_GT(mesh.vertices.size(), 1000U);
    ASSERT_EQ(mesh.colors.size(), mesh.vertices.size());
    std::vector<double> errors;  // a colour step of 1 corresponds to 1 cm
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const Eigen::Vector3d paint = paint_at(mesh.vertices[i].cast<double>());
        for (int c = 0; c < 3; ++c)
            errors.push_back(std::abs(mesh.colors[i][static_cast<std::size_t>(c)] - paint[c]));
    }
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(stats::upper_median(errors), 1.0);
    EXPECT_LT(errors[errors.size() * 98 / 100], 4.0);
}

TEST_P(BothVolumes, NormalsAndTrianglesFaceTheCameras) {
    const auto options = options_for(GetParam());
    const auto volume = fuse_views(bump_on_floor, views_from_above(6, 1.2), options);
    const types::Mesh mesh = surface_of(*volume, options);
    std::size_t num_away = 0;  // facing away from the cameras, which are all above
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3f normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                           .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        if (normal.z() < -0.3F * normal.norm()) ++num_away;
    }
    ASSERT_GT(mesh.triangles.size(), 4000U);
    EXPECT_LT(num_away, mesh.triangles.size() / 200);
}

TEST_P(BothVolumes, NoisyViewsOfAWallMakeOneWall) {
    const SceneDistance wall = [](const Eigen::Vector3d& p) { return p.z(); };
    const auto options = options_for(GetParam());
    const auto volume = fuse_views(
        wall, views_from_above(20, 1.2), options, {.sigma_px = 0.25, .stated_sigma_px = 0.25});
    const types::Mesh mesh = surface_of(*volume, options);
    const mesh::MeshComponents components = mesh::find_components(mesh);
    EXPECT_EQ(components.area_m2.size(), 1U);
    // Compares the area with its projection onto the wall: a second layer would double it.
    double shadow = 0.0;
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3f normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                           .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        shadow += 0.5 * normal.z();
    }
    EXPECT_LT(mesh::check_topology(mesh).area_m2, 1.3 * shadow);
    const auto distances = distances_from(wall, mesh);
    ASSERT_FALSE(distances.empty());
    EXPECT_LT(stats::upper_median(distances), 0.004);
}

TEST_P(BothVolumes, OneThreadAndTwoGiveTheSameBytes) {
    const TemporaryFolder folder;
    std::vector<types::Mesh> meshes;
    for (const int num_threads : {1, 2}) {
        const auto options = options_for(GetParam(), num_threads);
        const auto volume = fuse_views(bump_on_floor, views_from_above(3, 1.2), options);
        volume->save(folder / std::to_string(num_threads));
        meshes.push_back(surface_of(*volume, options));
    }
    ASSERT_FALSE(bytes_of(folder / "1").empty());
    EXPECT_EQ(bytes_of(folder / "1"), bytes_of(folder / "2"));
    ASSERT_GT(meshes[0].vertices.size(), 500U);
    EXPECT_EQ(meshes[0].vertices, meshes[1].vertices);
    EXPECT_EQ(meshes[0].triangles, meshes[1].triangles);
    EXPECT_EQ(meshes[0].colors, meshes[1].colors);
}

TEST_P(BothVolumes, ASavedVolumeGivesTheSameMesh) {
    const TemporaryFolder folder;
    const auto options = options_for(GetParam());
    const auto volume = fuse_views(bump_on_floor, views_from_above(4, 1.2), options);
    volume->save(folder / "volume");
    const auto loaded = load_volume(folder / "volume");
    EXPECT_EQ(loaded->voxel_m(), volume->voxel_m());
    const types::Mesh mesh = surface_of(*volume, options);
    ASSERT_GT(mesh.vertices.size(), 500U);
    EXPECT_EQ(surface_of(*loaded, options).vertices, mesh.vertices);
}

TEST_P(BothVolumes, AFileCutShortIsATypedError) {
    const TemporaryFolder folder;
    const auto options = options_for(GetParam());
    fuse_views(bump_on_floor, views_from_above(2, 1.2), options)->save(folder / "volume");
    const auto size = std::filesystem::file_size(folder / "volume");
    for (const auto keep : {size - 1, size / 2, std::uintmax_t{40}, std::uintmax_t{0}}) {
        std::filesystem::resize_file(folder / "volume", keep);
        EXPECT_THROW(load_volume(folder / "volume"), Error) << keep;
    }
    std::ofstream(folder / "other") << "not a volume at all";
    EXPECT_THROW(load_volume(folder / "other"), Error);
}

TEST_P(BothVolumes, BothMeshersFindTheSameSurface) {
    auto options = options_for(GetParam());
    const auto volume = fuse_views(bump_on_floor, views_from_above(6, 1.2), options);
    const double nets = mesh::check_topology(surface_of(*volume, options)).area_m2;
    options.mesher = "marching_cubes";
    const double cubes = mesh::check_topology(surface_of(*volume, options)).area_m2;
    EXPECT_NEAR(nets / cubes, 1.0, 0.12);  // the nets end one voxel earlier at the border
}

TEST_P(BothVolumes, WhatOneViewSawIsNotSurface) {
    const auto options = options_for(GetParam());
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    const SceneDistance floor = [](const Eigen::Vector3d& p) { return p.z(); };
    const SceneDistance with_fish = [](const Eigen::Vector3d& p) {
        return std::min(p.z(), (p - Eigen::Vector3d(0.0, 0.0, 0.5)).norm() - 0.12);
    };
    const auto poses = views_from_above(8, 1.2);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const auto view = render_view(i == 3 ? with_fish : floor, small_rig(), poses[i]);
        volume->integrate(view.keyframe, view.images);
    }
    const types::Mesh mesh = surface_of(*volume, options);
    ASSERT_GT(mesh.vertices.size(), 500U) << "the floor is to be there";
    for (const auto& vertex : mesh.vertices) EXPECT_LT(vertex.z(), 0.1F);
}

// The last of nine views looks at a place of its own.
TEST(TsdfVolume, WhatNoOtherViewCouldSeeIsSurface) {
    const ReconstructionOptions options = options_for("tsdf");
    const SceneDistance floor = [](const Eigen::Vector3d& p) { return p.z(); };
    const auto elsewhere = look_at({5.0, 0.0, 1.2}, {5.0, 0.1, 0.0});
    auto poses = views_from_above(8, 1.2);
    poses.push_back(elsewhere);
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    const cv::Mat measured =
        render_view(floor, small_rig(), poses.front()).images.depth.disparity_px;
    for (const auto& pose : poses) {
        const auto view = render_view(floor, small_rig(), pose);
        DepthView depth(small_rig(), view.images);
        mark_unshared(std::vector{OtherFrame{poses.front().inverse() * pose, measured}}, depth);
        volume->add(view.keyframe, depth);
    }
    const types::Mesh mesh = surface_of(*volume, options);
    const auto num = std::count_if(mesh.vertices.begin(), mesh.vertices.end(), [](const auto& p) {
        return std::abs(p.x() - 5.0F) < 0.3F && std::abs(p.z()) < 0.01F;
    });
    EXPECT_GT(num, 500);
}

// A floor that extends away from the cameras: half of a view is farther away than the depth for
// which the sampling was chosen.
TEST_P(BothVolumes, HalfSamplingLeavesNoHolesFarAway) {
    const SceneDistance floor = [](const Eigen::Vector3d& p) { return p.z(); };
    auto options = options_for(GetParam());
    options.voxel_m = 0.025;
    std::vector<double> areas_m2;
    for (const Sampling sampling : {Sampling::Full, Sampling::Half}) {
        auto volume = make_volume(choose_settings(small_rig(), options, 1.6), options);
        for (int i = 0; i < 4; ++i) {
            const Eigen::Vector3d eye(0.013 * i, 0.007 * i, 1.0);
            const auto view = render_view(
                floor, small_rig(), look_at(eye, eye + Eigen::Vector3d(0.0, 1.3, -1.0)));
            if (i == 0) {
                ASSERT_EQ(choose_sampling(small_rig(), view.images.depth, options.voxel_m),
                          Sampling::Half);
            }
            volume->add(view.keyframe, DepthView(small_rig(), view.images, sampling));
        }
        const types::Mesh mesh = surface_of(*volume, options);
        EXPECT_EQ(mesh::find_borders(mesh).num_holes, 0)
            << (sampling == Sampling::Half ? "half" : "full");
        areas_m2.push_back(mesh::check_topology(mesh).area_m2);
    }
    EXPECT_GT(areas_m2[1], 0.9 * areas_m2[0]);  // the border is wider
}

INSTANTIATE_TEST_SUITE_P(Volumes,
                         BothVolumes,
                         testing::Values("tsdf", "octree"),
                         [](const auto& volume) { return volume.param; });

// A fish at a different place in each of a third of the views; the rays of the other views pass
// through it.
TEST(TsdfVolume, RaysThatPassCarveAwayWhatSeveralViewsSaw) {
    const auto options = options_for("tsdf");
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    const auto poses = views_from_above(12, 1.2);
    for (int i = 0; i < 12; ++i) {
        const double along = 0.02 * i;  // slow, so that several views agree on a part of it
        const SceneDistance scene = [&](const Eigen::Vector3d& p) {
            const double fish = (p - Eigen::Vector3d(along, 0.0, 0.45)).norm() - 0.12;
            return i % 12 < 4 ? std::min(p.z(), fish) : p.z();
        };
        const auto view = render_view(scene, small_rig(), poses[i]);
        volume->integrate(view.keyframe, view.images);
    }
    const types::Mesh mesh = surface_of(*volume, options);
    ASSERT_GT(mesh.vertices.size(), 500U) << "the floor is to be there";
    for (const auto& vertex : mesh.vertices) EXPECT_LT(vertex.z(), 0.1F);
}

// An object that stands still in some views and that the other views see through.
class Ghost : public testing::TestWithParam<int> {};

TEST_P(Ghost, IsCarvedAwayByFiveViewsThatSeeThroughIt) {
    const auto options = options_for("tsdf");
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    const SceneDistance floor = [](const Eigen::Vector3d& p) { return p.z(); };
    const SceneDistance with_ghost = [](const Eigen::Vector3d& p) {
        return std::min(p.z(), (p - Eigen::Vector3d(0.0, 0.0, 0.45)).norm() - 0.12);
    };
    const int num_ghosts = GetParam();
    const auto poses = views_from_above(num_ghosts + 5, 1.2);
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const bool stands = static_cast<int>(i) < num_ghosts;
        const auto view = render_view(stands ? with_ghost : floor, small_rig(), poses[i]);
        volume->integrate(view.keyframe, view.images);
    }
    const types::Mesh mesh = surface_of(*volume, options);
    EXPECT_GT(mesh.vertices.size(), 1000U);
    for (const auto& vertex : mesh.vertices) EXPECT_LT(vertex.z(), 0.1F);
    std::array<std::uint8_t, 2> confirmed{};
    volume->confirm(std::array<Eigen::Vector3d, 2>{{{0.0, 0.0, 0.57}, {0.0, 0.0, 0.0}}},
                    confirmed.data());
    EXPECT_EQ(confirmed[0], 0);
    EXPECT_EQ(confirmed[1], 1);
}

INSTANTIATE_TEST_SUITE_P(InTwoViewsAndInFour, Ghost, testing::Values(2, 4));

// Views with larger errors than stated, as many too near as too far.
TEST(TsdfVolume, NoiseLargerThanStatedDoesNotPushTheSurfaceBack) {
    auto options = options_for("tsdf");
    options.voxel_m = 0.01;
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    const SceneDistance floor = [](const Eigen::Vector3d& p) { return p.z(); };
    const auto poses = views_from_above(25, 1.2);
    for (int i = 0; i < 25; ++i) {
        const double off_px = 0.1 * ((7 * i) % 25 - 12);  // each value from -1.2 to 1.2 once, mixed
        const auto view =
            render_view(floor, small_rig(), poses[i], {.bias_px = off_px, .stated_sigma_px = 0.4});
        volume->integrate(view.keyframe, view.images);
    }
    std::vector<float> heights_m;
    for (const auto& vertex : surface_of(*volume, options).vertices)
        if (vertex.head<2>().norm() < 0.3F) heights_m.push_back(vertex.z());
    ASSERT_GT(heights_m.size(), 1000U);
    EXPECT_NEAR(
        stats::upper_median(heights_m), 0.0F, 0.01F);  // one pixel of disparity is 53 mm there
}

// Matchers extend the foreground's disparity over its edge, then let it decrease to the
// background's within a few pixels.
void let_foreground_grow(cv::Mat& disparity) {
    cv::Mat grown;
    cv::dilate(disparity, grown, cv::Mat::ones(5, 5, CV_8U));
    cv::blur(grown, disparity, {3, 3});
}

TEST(TsdfVolume, AnEdgeOfTheForegroundGrowsNoSkirt) {
    const SceneDistance box_on_floor = [](const Eigen::Vector3d& p) {
        const Eigen::Vector3d outside = (p.cwiseAbs() - Eigen::Vector3d(0.15, 0.15, 0.4));
        const double box = outside.cwiseMax(0.0).norm() + std::min(0.0, outside.maxCoeff());
        return std::min(p.z(), box);
    };
    const auto options = options_for("tsdf");
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    for (const auto& pose : views_from_above(10, 1.2)) {
        auto view = render_view(box_on_floor, small_rig(), pose);
        let_foreground_grow(view.images.depth.disparity_px);
        volume->integrate(view.keyframe, view.images);
    }
    const types::Mesh mesh = surface_of(*volume, options);
    const auto distances = distances_from(box_on_floor, mesh);
    ASSERT_GT(distances.size(), 2000U);
    EXPECT_LT(distances.back(), 2.0 * kVoxel_m);
    const auto on_top = std::count_if(mesh.vertices.begin(),
                                      mesh.vertices.end(),
                                      [](const auto& v) { return std::abs(v.z() - 0.4F) < 0.01F; });
    EXPECT_GT(on_top, 200);
}

// With half sampling, a quarter of the pixels give the same planes.
TEST(DepthView, HalfSamplingFindsTheSamePlanes) {
    const SceneDistance slope = [](const Eigen::Vector3d& p) {
        return Eigen::Vector3d(0.2, -0.1, 1.0).normalized().dot(p);
    };
    const auto view = render_view(slope, small_rig(), views_from_above(1, 1.2).front());
    const DepthView full(small_rig(), view.images);
    const DepthView half(small_rig(), view.images, Sampling::Half);
    ASSERT_EQ(half.rig().width_px, small_rig().width_px / 2);
    for (int v = 10; v < half.rig().height_px - 10; v += 3)
        for (int u = 10; u < half.rig().width_px - 10; u += 3) {
            const SurfacePixel& a = full.pixel(2 * u, 2 * v);
            const SurfacePixel& b = half.pixel(u, v);
            ASSERT_GT(b.weight, 0.0F);
            EXPECT_NEAR(a.offset_m, b.offset_m, 1e-4F);
            for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(a.normal[axis], b.normal[axis], 1e-3F);
            const Eigen::Vector3d p = half.rig().point_cam(u, v, b.depth_m);
            EXPECT_LT(std::abs(slope(view.keyframe.T_world_cam * p)), 1e-4);
        }
}

TEST(DepthView, IsSampledByHalvesWhereAVoxelCoversTwoPixels) {
    const auto view = render_view([](const Eigen::Vector3d& p) { return p.z(); },
                                  small_rig(),
                                  views_from_above(1, 1.2).front());
    const double pixel_m = 1.2 / small_rig().focal_px;
    EXPECT_EQ(choose_sampling(small_rig(), view.images.depth, 2.3 * pixel_m), Sampling::Half);
    EXPECT_EQ(choose_sampling(small_rig(), view.images.depth, 1.5 * pixel_m), Sampling::Full);
}

TEST_P(BothVolumes, WhatSpillsToDiskChangesNoByte) {
    const TemporaryFolder folder;
    auto options = options_for(GetParam());
    options.voxel_m = 0.005;
    std::vector<types::Mesh> meshes;
    std::vector<std::int64_t> memory_bytes;
    for (const bool spilling : {false, true}) {
        options.fusion_memory_bytes = spilling ? std::int64_t{2} << 20 : std::int64_t{1} << 30;
        auto volume = make_volume(choose_settings(small_rig(), options, 1.0, folder / ""), options);
        for (const auto& pose : views_from_above(4, 1.2)) {
            const auto view = render_view(bump_on_floor, small_rig(), pose);
            volume->integrate(view.keyframe, view.images);
        }
        memory_bytes.push_back(volume->memory_bytes());
        volume->save(folder / std::to_string(spilling));
        meshes.push_back(surface_of(*volume, options));
    }
    EXPECT_LT(memory_bytes[1], memory_bytes[0] * 3 / 4);
    EXPECT_EQ(bytes_of(folder / "0"), bytes_of(folder / "1"));
    EXPECT_EQ(meshes[0].vertices, meshes[1].vertices);
    EXPECT_EQ(meshes[0].triangles, meshes[1].triangles);
}

// The variance of depth grows with the fourth power of the range. Views from 1.6 m that are all
// wrong by the same 0.15 px (18 mm) therefore move what views from 0.8 m measured correctly by less
// than a tenth of what equal weights would.
TEST(TsdfVolume, NearViewsOutweighFarOnesByTheFourthPowerOfTheRange) {
    const SceneDistance wall = [](const Eigen::Vector3d& p) { return p.z(); };
    const auto options = options_for("tsdf");
    auto volume = make_volume(choose_settings(small_rig(), options, 1.0), options);
    const double far_m = 1.6, bias_px = 0.15;
    const types::RectifiedRig rig = small_rig();
    const double far_error_m = far_m - rig.depth_m(rig.disparity_px(far_m) + bias_px);
    for (const auto& pose : views_from_above(5, 0.8)) {
        const auto near = render_view(wall, rig, pose);
        volume->integrate(near.keyframe, near.images);
    }
    for (const auto& pose : views_from_above(5, far_m)) {
        const auto far = render_view(wall, rig, pose, {.bias_px = bias_px});
        volume->integrate(far.keyframe, far.images);
    }
    std::vector<double> heights;
    for (const auto& vertex : surface_of(*volume, options).vertices)
        if (vertex.head<2>().norm() < 0.15F) heights.push_back(vertex.z());
    ASSERT_GT(heights.size(), 50U);
    const double median_m = stats::upper_median(heights);
    const double share = std::pow(0.8 / far_m, 4) / (1.0 + std::pow(0.8 / far_m, 4));
    EXPECT_NEAR(median_m, share * far_error_m, 0.35 * share * far_error_m);
    EXPECT_LT(median_m, 0.5 * far_error_m * 0.25);
}

TEST(ChooseVoxel, IsAboutACentimetreAtTwoMetresForARigOfAHandsBreadth) {
    const types::RectifiedRig rig = synthetic::ideal_rig(640, 480, 495.0);
    EXPECT_NEAR(choose_voxel_m(rig, 2.0), 0.009, 0.002);
    EXPECT_LT(choose_voxel_m(rig, 1.0), choose_voxel_m(rig, 2.0));
    EXPECT_GT(choose_max_depth_m(rig, 0.01), 3.0);
}

// At each level a view makes surface up to two limits: the depth that is chosen for its voxels, and
// the one at which 0.1 px of disparity are six voxels, which grow by a fifth per level at least.
TEST(FarthestSurface, IsBeyondTheLimitsOfEveryLevel) {
    const types::RectifiedRig rig = synthetic::ideal_rig(640, 480, 495.0);
    for (const double median_m : {0.3, 1.0, 2.0, 5.0})
        for (int level = 0; level <= kMaxRelativeLevel; ++level) {
            const double voxel_m = choose_voxel_m(rig, median_m);
            const double by_depth_m = choose_max_depth_m(rig, std::ldexp(voxel_m, level));
            const double by_sigma_m = std::sqrt(6.0 * std::exp2(0.25 * level) * voxel_m *
                                                rig.focal_px * rig.baseline_m / 0.1);
            EXPECT_GE(farthest_surface_m(rig, median_m), std::min(by_depth_m, by_sigma_m));
        }
}

// A dive mostly near its ground looks up into a hall: what 0.15 px of disparity tell to 1.5 % of
// its distance is surface there, whatever the median depth.
TEST(FarthestSurface, IsWhereTheDepthIsKnownToAShareOfItselfThoughMostOfTheDiveIsNear) {
    const types::RectifiedRig rig = synthetic::ideal_rig(640, 480, 495.0);
    const double known_m = 0.015 * rig.focal_px * rig.baseline_m / 0.15;
    for (const double median_m : {0.5, 0.7, 1.0, 2.0}) {
        EXPECT_GE(farthest_surface_m(rig, median_m), known_m) << median_m;
        const int level = relative_level(rig, median_m, known_m);
        EXPECT_GE(6.0 * tolerated_voxel_m(rig, choose_voxel_m(rig, median_m), level),
                  0.7 * 0.015 * known_m)
            << median_m;
    }
}

TEST(ToleratedVoxel, IsThatOfTheMedianDepthAtFinerLevelsAndGrowsWithCoarserOnes) {
    const types::RectifiedRig rig = synthetic::ideal_rig(640, 480, 495.0);
    for (int level = kMinRelativeLevel; level <= 0; ++level)
        EXPECT_EQ(tolerated_voxel_m(rig, 0.01, level), 0.01);
    for (int level = 1; level <= kMaxRelativeLevel; ++level)
        EXPECT_GT(tolerated_voxel_m(rig, 0.01, level), tolerated_voxel_m(rig, 0.01, level - 1));
}

}  // namespace
}  // namespace divemesh::fusion
