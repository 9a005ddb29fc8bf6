#include "worker/texture/face_views.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "schemas/error.hpp"
#include "tests/synthetic/texture.hpp"
#include "tests/worker/texture/square_mesh.hpp"

namespace divemesh::texture {
namespace {

const types::RectifiedRig kRig{.width_px = 320,
                               .height_px = 240,
                               .focal_px = 250.0,
                               .cx_px = 159.5,
                               .cy_px = 119.5,
                               .baseline_m = 0.1};

// Returns a keyframe that looks straight down (world z is up).
types::Keyframe above(int frame_index, double x_m, double y_m, double z_m) {
    types::Keyframe keyframe{.frame_index = frame_index};
    keyframe.T_world_cam.linear() =
        Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()).toRotationMatrix();
    keyframe.T_world_cam.translation() = Eigen::Vector3d(x_m, y_m, z_m);
    return keyframe;
}

// Returns the colour of the seabed, BGR.
Eigen::Vector3d bed_color(double x_m, double y_m) {
    const double light = 0.6 * synthetic::texture(400.0 * x_m, 400.0 * y_m);
    return {120.0 + light, 100.0 + light, 60.0 + 0.5 * light};
}

// A seabed at z = 0 before cameras that look straight down; the images are the truth of it.
class Dive {
public:
    types::Mesh mesh = square_mesh(1.0F, 40);
    std::vector<types::Keyframe> keyframes;
    // Changes the colour of a frame's pixel whose ray meets the seabed at a point.
    using Paint = std::function<void(Eigen::Vector3d& color, double x_m, double y_m)>;
    std::map<int, Paint> paint;

    cv::Mat image(int frame_index) const {
        const auto keyframe =
            std::find_if(keyframes.begin(), keyframes.end(), [&](const types::Keyframe& each) {
                return each.frame_index == frame_index;
            });
        const auto own = paint.find(frame_index);
        cv::Mat image(kRig.height_px, kRig.width_px, CV_8UC3);
        for (int v = 0; v < image.rows; ++v)
            for (int u = 0; u < image.cols; ++u) {
                const Eigen::Vector3d& camera = keyframe->T_world_cam.translation();
                const Eigen::Vector3d p = keyframe->T_world_cam * kRig.point_cam(u, v, camera.z());
                Eigen::Vector3d color = bed_color(p.x(), p.y());
                if (own != paint.end()) own->second(color, p.x(), p.y());
                for (int channel = 0; channel < 3; ++channel)
                    image.at<cv::Vec3b>(v, u)[channel] =
                        cv::saturate_cast<std::uint8_t>(color[channel]);
            }
        return image;
    }

    ChosenFaceViews choose(const keyframes::ReadImage& read_image, int num_threads = 2) const {
        return choose_face_views(
            mesh, kRig, keyframes, read_image, num_threads, base::ignore_progress);
    }
    ChosenFaceViews choose() const {
        return choose([this](int frame_index) { return image(frame_index); });
    }
};

bool all_are(const FaceViews& views, std::int32_t view) {
    return std::all_of(views.begin(), views.end(), [&](std::int32_t each) { return each == view; });
}

TEST(FaceViews, TheNearerKeyframeGivesTheColour) {
    Dive dive;
    dive.keyframes = {above(3, 0.0, 0.0, 4.0), above(7, 0.1, 0.0, 2.2)};
    const ChosenFaceViews chosen = dive.choose();
    EXPECT_EQ(chosen.face_views.size(), dive.mesh.triangles.size());
    EXPECT_TRUE(all_are(chosen.face_views, 1));
    EXPECT_TRUE(chosen.lost_frames.empty());
}

TEST(FaceViews, AKeyframeShowsOnlyWhatLiesWhollyInItsImage) {
    Dive dive;
    dive.keyframes = {above(0, 0.4, 0.0, 1.0)};  // sees x from 0.4 - 0.64 m to beyond the square
    const FaceViews views = dive.choose().face_views;
    for (std::size_t face = 0; face < views.size(); ++face) {
        const Eigen::Vector3f center = center_of(dive.mesh, face);
        const bool is_inside = center.x() > -0.24F + 0.025F && std::abs(center.y()) < 0.455F;
        const bool is_outside = center.x() < -0.24F || std::abs(center.y()) > 0.48F;
        if (is_inside) {
            EXPECT_EQ(views[face], 0) << center.transpose();
        }
        if (is_outside) {
            EXPECT_EQ(views[face], kNoView) << center.transpose();
        }
    }
}

TEST(FaceViews, SurfaceFromBehindOrNearerThanTheLeastDepthHasNoView) {
    Dive dive;
    dive.keyframes = {above(0, 0.0, 0.0, 2.0)};
    for (auto& triangle : dive.mesh.triangles) std::swap(triangle[1], triangle[2]);
    EXPECT_TRUE(all_are(dive.choose().face_views, kNoView));
    dive.mesh = square_mesh(0.02F, 4);
    dive.keyframes = {above(0, 0.0, 0.0, 0.04)};
    EXPECT_TRUE(all_are(dive.choose().face_views, kNoView));
}

TEST(FaceViews, WhatIsHiddenTakesTheKeyframeThatSeesIt) {
    Dive dive;
    const auto num_bed = static_cast<std::ptrdiff_t>(dive.mesh.triangles.size());
    add_square(dive.mesh, {0.0F, 0.0F, 1.0F}, 0.3F, 10);
    // The near keyframe sees the plate before the middle of the bed, the far one past it.
    dive.keyframes = {above(0, 0.0, 0.0, 2.0), above(1, 1.5, 0.0, 3.2)};
    FaceViews views = dive.choose().face_views;
    for (std::size_t face = 0; face < static_cast<std::size_t>(num_bed); ++face) {
        const Eigen::Vector3f center = center_of(dive.mesh, face).cwiseAbs();
        // The plate hides 0.6 m, as it is half way to the bed.
        if (std::max(center.x(), center.y()) < 0.28F) {
            EXPECT_EQ(views[face], 1);
        }
        if (std::max(center.x(), center.y()) > 0.45F) {
            EXPECT_EQ(views[face], 0);
        }
    }
    views.erase(views.begin(), views.begin() + num_bed);
    EXPECT_TRUE(all_are(views, 0));
}

// The fish is painted in the keyframe that is best everywhere.
class FaceViewsWithFish : public testing::Test {
protected:
    void SetUp() override {
        dive_.keyframes = {above(0, -0.1, 0.0, 3.6),
                           above(1, 0.0, 0.1, 2.2),
                           above(2, 0.1, 0.0, 3.5),
                           above(3, 0.0, -0.1, 3.7)};
        dive_.paint[1] = [](Eigen::Vector3d& color, double x_m, double y_m) {
            if (is_fish(x_m, y_m)) color = Eigen::Vector3d(30.0, 90.0, 180.0);
        };
    }
    static bool is_fish(double x_m, double y_m) {
        return std::hypot((x_m - 0.05) / 0.15, (y_m + 0.1) / 0.06) < 1.0;
    }
    // Expects that no face shows the fish, and that most others take the best keyframe.
    void expect_no_fish(const FaceViews& views) const {
        std::size_t num_best = 0;
        for (std::size_t face = 0; face < views.size(); ++face) {
            bool shows_fish = false;
            for (const std::uint32_t vertex : dive_.mesh.triangles[face]) {
                const Eigen::Vector3d p = dive_.mesh.vertices[vertex].cast<double>();
                shows_fish = shows_fish || is_fish(p.x(), p.y());
            }
            ASSERT_NE(views[face], kNoView);
            if (shows_fish) {
                EXPECT_NE(views[face], 1);
            }
            num_best += views[face] == 1 ? 1 : 0;
        }
        EXPECT_GT(num_best, views.size() * 8 / 10);  // the fish covers 3 %
    }

    Dive dive_;
};

TEST_F(FaceViewsWithFish, NoFaceTakesItsColourFromTheFish) {
    expect_no_fish(dive_.choose().face_views);
}

TEST_F(FaceViewsWithFish, ExposureAndWaterHideNoFish) {
    const auto fish = dive_.paint[1];
    for (const types::Keyframe& keyframe : dive_.keyframes)
        dive_.paint[keyframe.frame_index] = [&, i = keyframe.frame_index](
                                                Eigen::Vector3d& color, double x_m, double y_m) {
            if (i == 1) fish(color, x_m, y_m);
            const Eigen::Vector3d to_bed =
                Eigen::Vector3d(x_m, y_m, 0.0) - dive_.keyframes[i].T_world_cam.translation();
            const double exposure = i == 2 ? 2.0 : 1.0 + 0.1 * i;
            const Eigen::Array3d attenuation_per_m(0.05, 0.1, 0.5);
            color.array() *= exposure * (attenuation_per_m * (2.0 - to_bed.norm())).exp();
        };
    expect_no_fish(dive_.choose().face_views);
}

TEST_F(FaceViewsWithFish, TheNumberOfThreadsChangesNothing) {
    std::map<int, cv::Mat> images;
    for (const types::Keyframe& keyframe : dive_.keyframes)
        images[keyframe.frame_index] = dive_.image(keyframe.frame_index);
    const auto read = [&](int frame_index) { return images.at(frame_index); };
    const FaceViews views = dive_.choose(read, 1).face_views;
    EXPECT_EQ(views, dive_.choose(read, 2).face_views);
    EXPECT_EQ(views, dive_.choose(read, 3).face_views);
}

TEST_F(FaceViewsWithFish, UnreadableImagesAreLeftOutAndNamed) {
    const auto read = [&](int frame_index) -> cv::Mat {
        if (frame_index == 1) throw Error(ErrorCode::NotFound, "no such file");
        if (frame_index == 3) return {};
        return dive_.image(frame_index);
    };
    const ChosenFaceViews chosen = dive_.choose(read);
    EXPECT_EQ(chosen.lost_frames, (std::vector<int>{1, 3}));
    for (const std::int32_t view : chosen.face_views) EXPECT_TRUE(view == 0 || view == 2);
    const ChosenFaceViews none = dive_.choose([](int) { return cv::Mat(); });
    EXPECT_TRUE(all_are(none.face_views, kNoView));
    EXPECT_EQ(none.lost_frames.size(), 4U);
}

TEST_F(FaceViewsWithFish, GreyAndSmallImagesServeToo) {
    const auto read = [&](int frame_index) {
        const cv::Mat image = dive_.image(frame_index);
        cv::Mat grey(image.rows / 2, image.cols / 2, CV_8UC1);
        for (int v = 0; v < grey.rows; ++v)
            for (int u = 0; u < grey.cols; ++u)
                grey.at<std::uint8_t>(v, u) = image.at<cv::Vec3b>(2 * v, 2 * u)[2];
        return grey;
    };
    expect_no_fish(dive_.choose(read).face_views);
}

TEST(FaceViews, AnEmptyMeshAndADiveWithoutKeyframesAreNoError) {
    Dive dive;
    const ChosenFaceViews unseen = dive.choose();
    EXPECT_TRUE(all_are(unseen.face_views, kNoView));
    dive.keyframes = {above(0, 0.0, 0.0, 2.0)};
    dive.mesh = {};
    EXPECT_TRUE(dive.choose().face_views.empty());
}

TEST(FaceViews, CancellationIsPassedOn) {
    Dive dive;
    dive.keyframes = {above(0, 0.0, 0.0, 2.0)};
    const auto cancelled = [](int) -> cv::Mat { throw Error(ErrorCode::Cancelled, "cancelled"); };
    EXPECT_THROW(dive.choose(cancelled), Error);
}

}  // namespace
}  // namespace divemesh::texture
