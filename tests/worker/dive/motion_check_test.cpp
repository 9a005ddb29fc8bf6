#include "worker/dive/motion_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/worker/dive/finding_matcher.hpp"
#include "worker/base/rotation_vector.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumFrames = 40;
constexpr int kSamplesPerFrame = 10;
constexpr double kSamplePeriod_s = 0.01;
constexpr double kWall_m = 2.0;  // ahead of the rig
constexpr double kTexture_px_m = 300.0;
constexpr double kBaseline_m = 0.12;

// A rig that turns to all sides in front of a textured wall, in the plane z = kWall_m of the world,
// recorded by images of some width.
class Swim {
public:
    explicit Swim(int width_px) {
        cv::Mat noise(1300, 1500, CV_8UC1);
        cv::RNG(7).fill(noise, cv::RNG::UNIFORM, 0, 255);
        cv::GaussianBlur(noise, texture_, {}, 1.5);
        cv::normalize(texture_, texture_, 20, 235, cv::NORM_MINMAX);
        const int height_px = width_px * 9 / 16;
        const double focal_px = width_px / 1.28;
        contents.rig.cam0 = {width_px,
                             height_px,
                             focal_px,
                             focal_px,
                             0.5 * width_px - 0.5,
                             0.5 * height_px - 0.5,
                             types::Distortion::None,
                             {}};
        contents.rig.cam1 = contents.rig.cam0;
        contents.has_rig = true;
        mount(R_imu_cam_);
        add_motion();
    }

    // States a mounting of the cameras, whatever the images show.
    void mount(const Eigen::Matrix3d& R_imu_cam) {
        contents.rig.T_imu_cam0.linear() = R_imu_cam;
        contents.rig.T_imu_cam1 =
            contents.rig.T_imu_cam0 * Eigen::Translation3d(kBaseline_m, 0.0, 0.0);
    }

    const Eigen::Matrix3d& R_imu_cam() const { return R_imu_cam_; }

    cv::Mat seen_by(int camera, int frame) const {
        const auto sample = static_cast<std::size_t>(frame * kSamplesPerFrame);
        const Eigen::Matrix3d R_world_cam = orientations_[sample].toRotationMatrix() * R_imu_cam_;
        const Eigen::Vector3d p_world = R_world_cam * Eigen::Vector3d(camera * kBaseline_m, 0, 0);
        const types::Camera& lens = camera == 0 ? contents.rig.cam0 : contents.rig.cam1;
        Eigen::Matrix3d ray_from_px;
        ray_from_px << 1.0 / lens.fx_px, 0, -lens.cx_px / lens.fx_px, 0, 1.0 / lens.fy_px,
            -lens.cy_px / lens.fy_px, 0, 0, 1;
        Eigen::Matrix3d wall_from_ray;
        wall_from_ray << kWall_m - p_world.z(), 0, p_world.x(), 0, kWall_m - p_world.z(),
            p_world.y(), 0, 0, 1;
        Eigen::Matrix3d texture_from_wall;
        texture_from_wall << kTexture_px_m, 0, 0.5 * texture_.cols, 0, kTexture_px_m,
            0.5 * texture_.rows, 0, 0, 1;
        const Eigen::Matrix3d texture_from_px =
            texture_from_wall * wall_from_ray * R_world_cam * ray_from_px;
        cv::Matx33d map;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) map(i, j) = texture_from_px(i, j);
        cv::Mat image;
        cv::warpPerspective(texture_,
                            image,
                            map,
                            {lens.width_px, lens.height_px},
                            cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                            cv::BORDER_REFLECT);
        return image;
    }

    DiveContents contents;

private:
    void add_motion() {
        const auto stamp_ns = [](int sample) {
            return std::int64_t{1'000'000'000} + std::int64_t{10'000'000} * sample;
        };
        orientations_.emplace_back(R_imu_cam_.transpose());  // the camera looks at the wall
        contents.imu.push_back({stamp_ns(0)});
        for (int i = 1; i <= kNumFrames * kSamplesPerFrame; ++i) {
            const double t = kSamplePeriod_s * i;
            const Eigen::Vector3d rate_imu(
                0.4 * std::sin(2.9 * t), 0.4 * std::cos(2.3 * t), 0.3 * std::sin(1.7 * t + 1.0));
            contents.imu.push_back({stamp_ns(i), rate_imu});
            orientations_.push_back(orientations_.back() *
                                    base::rotation_from_vector(rate_imu * kSamplePeriod_s));
        }
        for (int i = 0; i < kNumFrames; ++i) {
            const std::int64_t time_ns = stamp_ns(i * kSamplesPerFrame);
            contents.frames.pairs.push_back({time_ns, "", "", time_ns});
        }
    }

    const Eigen::Matrix3d R_imu_cam_ =
        base::rotation_from_vector({0.3, -0.2, 1.1}).toRotationMatrix();
    cv::Mat texture_;
    std::vector<Eigen::Quaterniond> orientations_;  // of the imu in the world, by sample
};

// `image_of` returns the image of a camera at a frame.
std::vector<Finding> findings_of(const Swim& swim,
                                 const std::function<cv::Mat(int camera, int frame)>& image_of) {
    FindingLog log;
    check_motion(
        swim.contents,
        [&](int index, Eyes eyes) {
            LoadedPair pair;
            pair.index = index;
            pair.left.image = image_of(0, index);
            if (eyes == Eyes::Both) pair.right.image = image_of(1, index);
            return pair;
        },
        base::ignore_progress,
        log);
    return log.all();
}

// `left`: the camera whose images are those of cam0.
std::vector<Finding> findings_of(const Swim& swim, int left = 0) {
    return findings_of(swim, [&](int camera, int frame) {
        return swim.seen_by(camera == 0 ? left : 1 - left, frame);
    });
}

// The larger images are compared at half their size.
class MotionCheckTest : public testing::TestWithParam<int> {};

TEST_P(MotionCheckTest, ARigAsCalibratedGetsNoFinding) {
    EXPECT_TRUE(findings_of(Swim(GetParam())).empty());
}

TEST_P(MotionCheckTest, SwappedImagesAreNamed) {
    EXPECT_THAT(findings_of(Swim(GetParam()), 1),
                HasFinding(Severity::Error, "cameras_swapped", "behind the cameras"));
}

// The second camera lies lower in its images: these keep their rows if mirrored from left to right,
// and lose them if turned upside down, or if the cameras are swapped.
TEST_P(MotionCheckTest, ImagesThatAreBothMirroredAreNamed) {
    Swim swim(GetParam());
    swim.contents.rig.cam1.cy_px += 8.0;
    EXPECT_TRUE(findings_of(swim).empty());
    const auto findings_mirrored = [&](int flip) {
        return findings_of(swim, [&](int camera, int frame) {
            cv::Mat image;
            cv::flip(swim.seen_by(camera, frame), image, flip);
            return image;
        });
    };
    EXPECT_THAT(findings_mirrored(1),
                HasFinding(Severity::Error, "camera_turned", "both images are mirrored"));
    EXPECT_THAT(findings_mirrored(0),
                HasFinding(Severity::Warning, "camera_turned", "from top to bottom"));
}

TEST_P(MotionCheckTest, AKnockedCameraIsNotTakenForFlippedImages) {
    Swim swim(GetParam());
    swim.contents.rig.cam1.cy_px += 8.0;
    const Swim as_recorded = swim;
    swim.contents.rig.cam1.cy_px += 6.0;  // the calibration of another day
    const auto findings = findings_of(
        swim, [&](int camera, int frame) { return as_recorded.seen_by(camera, frame); });
    EXPECT_THAT(findings, testing::Not(HasFinding(Severity::Warning, "camera_turned", "")));
}

TEST_P(MotionCheckTest, AnInvertedMountingIsNamed) {
    Swim swim(GetParam());
    swim.mount(swim.R_imu_cam().transpose());
    EXPECT_THAT(findings_of(swim),
                HasFinding(Severity::Error, "extrinsics_inverted", "T_BS looks inverted"));
}

INSTANTIATE_TEST_SUITE_P(Widths, MotionCheckTest, testing::Values(640, 1280));

TEST(MotionCheckOfLargeImagesTest, LeavesAFixedPatternOut) {
    Swim swim(1280);
    swim.contents.fixed_pattern = cv::Mat(720, 1280, CV_8UC1, cv::Scalar(255));
    EXPECT_TRUE(findings_of(swim, 1).empty()) << "no corner is left";
    swim.contents.fixed_pattern.colRange(200, 1100) = 0;
    EXPECT_THAT(findings_of(swim, 1), HasFinding(Severity::Error, "cameras_swapped", ""));
}

}  // namespace
}  // namespace divemesh::dive
