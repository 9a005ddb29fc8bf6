#include "worker/color/surface_sightings.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "schemas/error.hpp"
#include "tests/worker/color/water_world.hpp"
#include "tests/worker/texture/square_mesh.hpp"
#include "worker/color/restore_vertices.hpp"
#include "worker/color/restored_images.hpp"

namespace divemesh::color {
namespace {

const types::RectifiedRig kRig{.width_px = 160,
                               .height_px = 120,
                               .focal_px = 125.0,
                               .cx_px = 79.5,
                               .cy_px = 59.5,
                               .baseline_m = 0.1};
constexpr std::array<double, 3> kSand = {0.5, 0.45, 0.35};

// Sand at z = 0 under green water, before cameras that look straight down from several heights; the
// images are drawn from the model.
class SandUnderWater {
public:
    types::Mesh mesh = texture::square_mesh(3.0F, 60);
    std::vector<types::Keyframe> keyframes;
    std::array<ChannelFit, 3> water = green_water();

    SandUnderWater() {
        mesh.normals.assign(mesh.vertices.size(), Eigen::Vector3f::UnitZ());
        mesh.colors.assign(mesh.vertices.size(), types::Color{1, 2, 3});
        for (int i = 0; i < 6; ++i) {
            types::Keyframe keyframe{.frame_index = 10 * i};
            keyframe.T_world_cam.linear() =
                Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
            keyframe.T_world_cam.translation() = Eigen::Vector3d(0.05 * i, 0.0, 1.0 + 0.3 * i);
            keyframes.push_back(keyframe);
        }
    }

    types::KeyframeImages read(int frame_index) const {
        const auto& keyframe = keyframes[static_cast<std::size_t>(frame_index / 10)];
        const double height_m = keyframe.T_world_cam.translation().z();
        types::KeyframeImages images;
        images.left_color.create(kRig.height_px, kRig.width_px, CV_8UC3);
        for (int v = 0; v < kRig.height_px; ++v)
            for (int u = 0; u < kRig.width_px; ++u) {
                const double range_m = kRig.point_cam(u, v, height_m).norm();
                for (std::size_t c = 0; c < 3; ++c)
                    images.left_color.at<cv::Vec3b>(v, u)[static_cast<int>(2 - c)] =
                        level_of(static_cast<float>(light(c, range_m)));
            }
        return images;
    }
    ReadKeyframe reader() const {
        return [this](int frame_index) { return read(frame_index); };
    }
    Sightings sightings(const ReadKeyframe& reader, int num_threads = 2) const {
        return surface_sightings(
            SeenSurface(mesh, kRig), keyframes, reader, num_threads, {"color"});
    }
    double light(std::size_t channel, double range_m) const {
        return kSand[channel] * direct_of(water[channel], LightSource::Ambient, range_m, 1.0) +
               backscatter(water[channel], range_m);
    }
    Restorer restorer() const {
        ColorFit fit;
        fit.outcome = FitOutcome::Estimated;
        fit.channels = water;
        fit.near_m = 0.8;
        fit.far_m = 4.0;
        fit.log_gains.assign(keyframes.size(), 0.0);
        return {fit, {}};
    }
};

TEST(SurfaceSightings, HaveTheRangeAndTheLinearLightOfTheSurface) {
    const SandUnderWater sand;
    const Sightings sightings = sand.sightings(sand.reader());
    EXPECT_EQ(sightings.num_keyframes, 6U);
    ASSERT_GT(sightings.all.size(), 3000U);
    double nearest_m = 1e9;
    double farthest_m = 0.0;
    for (const Sighting& sighting : sightings.all) {
        const double range_m = static_cast<double>(sighting.range_m);
        nearest_m = std::min(nearest_m, range_m);
        farthest_m = std::max(farthest_m, range_m);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(sighting.rgb[c], sand.light(c, range_m), 0.02 * sand.light(c, range_m));
        EXPECT_GE(sighting.eccentricity, 0.0F);
        EXPECT_LE(sighting.eccentricity, 1.0F);
        // They look straight down.
        const double height_m = sand.keyframes[sighting.keyframe].T_world_cam.translation().z();
        EXPECT_NEAR(sighting.cosine, height_m / range_m, 1e-3);
    }
    EXPECT_NEAR(nearest_m, 1.0, 0.01);
    EXPECT_GT(farthest_m, 2.8);
}

TEST(SurfaceSightings, LeaveOutWhatIsHiddenOrOtherwiseDeep) {
    SandUnderWater sand;
    const std::size_t num_visible = sand.sightings(sand.reader()).all.size();
    // A fish swims over the sand in one frame: its depth was measured, half of the way.
    const auto with_fish = [&sand](int frame_index) {
        types::KeyframeImages images = sand.read(frame_index);
        const double height_m = sand.keyframes[static_cast<std::size_t>(frame_index / 10)]
                                    .T_world_cam.translation()
                                    .z();
        images.depth.disparity_px =
            cv::Mat(kRig.height_px,
                    kRig.width_px,
                    CV_32F,
                    cv::Scalar(kRig.disparity_px(frame_index == 20 ? 0.5 * height_m : height_m)));
        return images;
    };
    const Sightings sightings = sand.sightings(with_fish);
    ASSERT_GT(sightings.all.size(), 1000U);
    EXPECT_LT(sightings.all.size(), num_visible);
    for (const Sighting& sighting : sightings.all) EXPECT_NE(sighting.keyframe, 2U);
    // A roof above all cameras but the lowest hides the sand from them.
    texture::add_square(sand.mesh, {0.0F, 0.0F, 1.15F}, 6.0F, 20);
    const Sightings below_roof = sand.sightings(sand.reader());
    ASSERT_GT(below_roof.all.size(), 100U);
    for (const Sighting& sighting : below_roof.all)
        EXPECT_TRUE(sighting.keyframe == 0 || sighting.range_m < 2.5F);
}

TEST(SurfaceSightings, LeaveOutImagesThatCannotBeReadAndSaturatedOnes) {
    const SandUnderWater sand;
    const auto failing = [&sand](int frame_index) {
        if (frame_index == 10) throw Error(ErrorCode::NotFound, "gone");
        types::KeyframeImages images = sand.read(frame_index);
        if (frame_index == 30) images.left_color.setTo(cv::Scalar::all(255));
        return images;
    };
    const Sightings sightings = sand.sightings(failing);
    ASSERT_GT(sightings.all.size(), 1000U);
    for (const Sighting& sighting : sightings.all) {
        EXPECT_NE(sighting.keyframe, 1U);
        EXPECT_NE(sighting.keyframe, 3U);
    }
    const auto cancelled = [](int) -> types::KeyframeImages {
        throw Error(ErrorCode::Cancelled, "cancelled");
    };
    EXPECT_THROW(sand.sightings(cancelled), Error);
}

TEST(SurfaceSightings, CountTheImagesThatCannotBeRead) {
    const SandUnderWater sand;
    const auto broken = [&sand](int frame_index) {
        if (frame_index == 10) throw cv::Exception(cv::Error::StsError, "broken", "decode", "", 1);
        if (frame_index == 20) throw Error(ErrorCode::NotFound, "gone");
        types::KeyframeImages images = sand.read(frame_index);
        if (frame_index == 40) images.left_color = images.left_color.colRange(0, 50).clone();
        if (frame_index == 50) images.depth.disparity_px = cv::Mat::zeros(50, 50, CV_32F);
        return images;
    };
    const Sightings sightings = sand.sightings(broken);
    EXPECT_EQ(sightings.num_lost_images, 4U);
    EXPECT_GT(sightings.all.size(), 1000U);
    const auto lost = [](int) -> types::KeyframeImages {
        throw cv::Exception(cv::Error::StsError, "broken", "decode", "", 1);
    };
    EXPECT_EQ(sand.sightings(lost).num_lost_images, 6U);
}

TEST(SurfaceSightings, OfNoSurfaceAreEmpty) {
    SandUnderWater sand;
    const auto unread = [](int) -> types::KeyframeImages {
        throw std::logic_error("there is no need to read this");
    };
    sand.mesh.triangles.assign(10, {0, 0, 0});  // without area
    EXPECT_EQ(sand.sightings(unread).num_points, 0U);
    sand.mesh = {};
    EXPECT_TRUE(sand.sightings(unread).all.empty());
}

// A camera that hovers for long shows each point far more often than a fit can use.
TEST(SurfaceSightings, KeepAFewOfEachPointFromAllItsRanges) {
    SandUnderWater sand;
    const types::Keyframe hovering = sand.keyframes[0];
    sand.keyframes.insert(sand.keyframes.begin(), 100, hovering);
    for (std::size_t i = 0; i < sand.keyframes.size(); ++i)
        sand.keyframes[i].frame_index = static_cast<int>(10 * i);
    const Sightings one = sand.sightings(sand.reader(), 1);
    ASSERT_GT(one.num_points, 1000U);
    ASSERT_GT(one.all.size(), 1000U);
    std::vector<std::size_t> num(one.num_points, 0);
    std::size_t num_late = 0;
    for (const Sighting& sighting : one.all) {
        ++num[sighting.point];
        if (sighting.keyframe > 100) ++num_late;
    }
    EXPECT_EQ(*std::max_element(num.begin(), num.end()), 32U);
    EXPECT_EQ(num_late, [&] {
        SandUnderWater leaving;
        std::size_t count = 0;
        for (const Sighting& sighting : leaving.sightings(leaving.reader()).all)
            if (sighting.keyframe > 0) ++count;
        return count;
    }());
    const Sightings eight = sand.sightings(sand.reader(), 8);
    ASSERT_EQ(one.all.size(), eight.all.size());
    for (std::size_t i = 0; i < one.all.size(); ++i) {
        EXPECT_EQ(one.all[i].keyframe, eight.all[i].keyframe);
        EXPECT_EQ(one.all[i].rgb, eight.all[i].rgb);
    }
}

TEST(RestoredImages, ShowTheSandWithoutWater) {
    const SandUnderWater sand;
    const auto images = restored_images(
        sand.mesh,
        kRig,
        sand.keyframes,
        [&sand](int frame_index) { return sand.read(frame_index).left_color; },
        sand.restorer());
    for (const int frame_index : {0, 50}) {
        const cv::Mat image = images(frame_index);
        for (int v = 10; v < kRig.height_px; v += 20)
            for (int u = 10; u < kRig.width_px; u += 20)
                for (std::size_t c = 0; c < 3; ++c)
                    EXPECT_NEAR(image.at<cv::Vec3b>(v, u)[static_cast<int>(2 - c)],
                                level_of(static_cast<float>(kSand[c])),
                                4);
    }
}

TEST(RestoreVertices, GivesVerticesTheColourOfTheSand) {
    const SandUnderWater sand;
    const RestoredVertices restored = restore_vertices(
        SeenSurface(sand.mesh, kRig), sand.keyframes, sand.reader(), sand.restorer(), 2, {"color"});
    ASSERT_EQ(restored.colors.size(), sand.mesh.vertices.size());
    EXPECT_EQ(restored.limited_share, 0.0);
    for (const types::Color& color : restored.colors)  // also those beside all images
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(color[c], level_of(static_cast<float>(kSand[c])), 3);
}

TEST(RestoreVertices, NeedNormals) {
    SandUnderWater sand;
    sand.mesh.normals.clear();
    const SeenSurface surface(sand.mesh, kRig);
    EXPECT_THROW(
        restore_vertices(surface, sand.keyframes, sand.reader(), sand.restorer(), 2, {"color"}),
        std::logic_error);
}

}  // namespace
}  // namespace divemesh::color
