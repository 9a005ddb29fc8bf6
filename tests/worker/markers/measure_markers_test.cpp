#include <cmath>
#include <gmock/gmock.h>
#include <map>
#include <memory>
#include <random>

#include "tests/synthetic/ideal_rig.hpp"
#include "tests/worker/markers/drawn_tags.hpp"
#include "worker/markers/find_tags.hpp"
#include "worker/markers/measure_bars.hpp"
#include "worker/markers/survey_markers.hpp"
#include "worker/markers/world_scale.hpp"

namespace divemesh::markers {
namespace {

// A swim over tags on the ground: the observations in every keyframe, with reading errors.
class MarkerSwim {
public:
    explicit MarkerSwim(int num_tags, unsigned seed = 1) : random_(seed) {
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        for (int id = 0; id < num_tags; ++id) {
            DrawnTag tag{.id = id, .size_m = 0.1};
            tag.T_world_marker.translation() =
                Eigen::Vector3d(0.25 * id, 0.15 * any(random_), 0.05 * any(random_));
            tag.T_world_marker.linear() =
                (Eigen::AngleAxisd(3.0 * any(random_), Eigen::Vector3d::UnitZ()) *
                 Eigen::AngleAxisd(0.2 * any(random_), Eigen::Vector3d::UnitX()))
                    .toRotationMatrix();
            tags_.push_back(tag);
        }
        for (int i = 0; i < 4 * num_tags; ++i) {
            types::Keyframe keyframe;
            keyframe.frame_index = i;
            keyframe.timestamp_ns = i;
            keyframe.T_world_cam =
                looking_down({0.08 * i - 0.1, 0.05 * any(random_), 1.0}, 0.1, 0.1 * any(random_));
            keyframes_.push_back(keyframe);
        }
    }

    std::vector<TagView> views(double sigma_px) {
        std::normal_distribution<double> error(0.0, sigma_px);
        std::vector<TagView> result;
        for (std::size_t k = 0; k < keyframes_.size(); ++k)
            for (const DrawnTag& tag : tags_)
                for (const bool is_right : {false, true}) {
                    TagView view{tag.id, k, is_right, {}};
                    bool inside = true;
                    for (std::size_t i = 0; i < dive::kNumTagCorners; ++i) {
                        const auto pixel =
                            seen(k, is_right, tag.corner_world(static_cast<dive::TagCorner>(i)));
                        inside = inside && pixel.x() > 0 && pixel.x() < 640 && pixel.y() > 0 &&
                                 pixel.y() < 480;
                        view.corners_px[i] =
                            pixel + Eigen::Vector2d(error(random_), error(random_));
                    }
                    if (inside) result.push_back(view);
                }
        return result;
    }

    dive::MarkerPlan plan() const {
        dive::MarkerPlan plan;
        for (std::size_t i = 0; i + 1 < tags_.size(); ++i)
            plan.scale_bars.push_back(
                {.name = "bar " + std::to_string(i),
                 .from = {static_cast<int>(i), std::nullopt},
                 .to = {static_cast<int>(i) + 1, dive::TagCorner::TopLeft},
                 .distance_m = (tags_[i].T_world_marker.translation() -
                                tags_[i + 1].corner_world(dive::TagCorner::TopLeft))
                                   .norm()});
        return plan;
    }

    // Adds independent errors to the poses, as in a reconstruction.
    void shake_poses(double position_m, double rotation_rad) {
        std::normal_distribution<double> error;
        for (types::Keyframe& keyframe : keyframes_) {
            const Eigen::Vector3d axis(error(random_), error(random_), error(random_));
            keyframe.T_world_cam.translation() +=
                position_m * Eigen::Vector3d(error(random_), error(random_), error(random_));
            keyframe.T_world_cam.linear() *=
                Eigen::AngleAxisd(rotation_rad * axis.norm(), axis.normalized()).toRotationMatrix();
        }
    }

    MarkerWorld world() const { return {rig_, keyframes_, trajectory_, covariances_}; }
    // Has all later views come from cameras with a rolling shutter, which move alike at each
    // keyframe.
    void roll(double readout_time_s, const camera::CameraMotion& motion) {
        std::map<int, camera::CameraMotion> motions;
        for (const types::Keyframe& keyframe : keyframes_) motions[keyframe.frame_index] = motion;
        shutter_ = std::make_unique<camera::ShutterCorrection>(
            rig_,
            camera::rectified_lenses(synthetic::ideal_cameras(rig_))[0],
            readout_time_s,
            std::move(motions));
    }
    const camera::ShutterCorrection* shutter() const { return shutter_.get(); }
    const std::vector<DrawnTag>& tags() const { return tags_; }
    std::vector<types::Keyframe>& keyframes() { return keyframes_; }
    types::RectifiedRig& rig() { return rig_; }

private:
    Eigen::Vector2d seen(std::size_t k, bool is_right, const Eigen::Vector3d& p_world) const {
        Eigen::Isometry3d T_world_cam = keyframes_[k].T_world_cam;
        Eigen::Vector2d pixel;
        for (int i = 0; i < 10; ++i) {
            Eigen::Vector3d p_cam = T_world_cam.inverse() * p_world;
            if (is_right) p_cam.x() -= rig_.baseline_m;
            pixel = rig_.pixel(p_cam);
            if (!shutter_) break;
            T_world_cam = keyframes_[k].T_world_cam *
                          shutter_->motion_until_row(keyframes_[k].frame_index, pixel);
        }
        return pixel;
    }

    std::mt19937 random_;
    types::RectifiedRig rig_ = test_rig();
    std::vector<DrawnTag> tags_;
    std::vector<types::Keyframe> keyframes_;
    types::Trajectory trajectory_;
    types::CovarianceTrack covariances_;
    std::unique_ptr<camera::ShutterCorrection> shutter_;
};

std::vector<std::string> codes(const MarkerMetrics& metrics) {
    std::vector<std::string> result;
    for (const Finding& finding : metrics.findings) result.push_back(finding.code);
    return result;
}

TEST(MeasureMarkersTest, TagsReadWithoutErrorLieWhereTheyAre) {
    MarkerSwim swim(6);

    const MarkerMetrics metrics = measure_markers(swim.views(0.0), swim.plan(), swim.world());

    ASSERT_EQ(metrics.markers.size(), 6U);
    for (std::size_t i = 0; i < 6; ++i)
        EXPECT_TRUE(
            metrics.markers[i].T_world_marker.isApprox(swim.tags()[i].T_world_marker, 1e-6));
    ASSERT_EQ(metrics.bars.size(), 5U);
    for (const BarMetrics& bar : metrics.bars) EXPECT_NEAR(bar.error_m(), 0.0, 1e-7);
    EXPECT_NEAR(metrics.scale->factor, 1.0, 1e-6);
    EXPECT_TRUE(metrics.findings.empty());
}

TEST(MeasureMarkersTest, TagsOfARollingShutterAreSeenFromWhereTheirRowWasRead) {
    MarkerSwim swim(6);
    swim.roll(0.03, {{0.1, -0.2, 0.15}, {0.3, 0.2, 0.0}});
    const auto views = swim.views(0.0);
    const auto max_error_m = [&](const MarkerWorld& world) {
        double error_m = 0.0;
        for (const BarMetrics& bar : measure_markers(views, swim.plan(), world).bars)
            error_m = std::max(error_m, std::abs(bar.error_m()));
        return error_m;
    };
    MarkerWorld corrected = swim.world();
    corrected.shutter = swim.shutter();
    EXPECT_GT(max_error_m(swim.world()), 1e-3);
    // Corners are not read at the time of the centre.
    EXPECT_LT(max_error_m(corrected), 0.3 * max_error_m(swim.world()));
}

// Returns the share of bars whose true length lies in the stated interval, over several dives.
double covered_share(double reading_px, double position_m, double rotation_rad) {
    int num = 0;
    int num_covered = 0;
    for (unsigned seed = 1; seed <= 12; ++seed) {
        MarkerSwim swim(6, seed);
        const auto views = swim.views(reading_px);
        swim.shake_poses(position_m, rotation_rad);
        for (const BarMetrics& bar : measure_markers(views, swim.plan(), swim.world()).bars) {
            ++num;
            if (std::abs(bar.error_m()) < 1.96 * bar.own_sigma_m) ++num_covered;
        }
    }
    EXPECT_EQ(num, 60);
    return static_cast<double>(num_covered) / num;
}

TEST(MeasureMarkersTest, OwnSigmasHoldForErrorsOfReading) {
    const double share = covered_share(0.3, 0.0, 0.0);
    EXPECT_GE(share, 0.80);
    EXPECT_LE(share, 1.0);
}

TEST(MeasureMarkersTest, OwnSigmasHoldForErrorsOfPoses) {
    const double share = covered_share(0.1, 0.001, 0.001);
    EXPECT_GE(share, 0.80);
    EXPECT_LE(share, 1.0);
}

TEST(MeasureMarkersTest, AFalseTagMovesNothing) {
    MarkerSwim swim(5);
    auto views = swim.views(0.1);
    const auto good = measure_markers(views, swim.plan(), swim.world());
    std::size_t num_false = 0;
    for (TagView& view : views)  // id 3 is sometimes read far from its true place
        if (view.id == 3 && view.keyframe % 4 == 0 && ++num_false > 0)
            for (auto& corner : view.corners_px) corner += Eigen::Vector2d(60, 40);
    ASSERT_GT(num_false, 0U);

    const auto metrics = measure_markers(views, swim.plan(), swim.world());

    ASSERT_EQ(metrics.markers.size(), 5U);
    EXPECT_EQ(metrics.markers[3].num_rejected_views, static_cast<int>(num_false));
    EXPECT_LT((metrics.markers[3].T_world_marker.translation() -
               swim.tags()[3].T_world_marker.translation())
                  .norm(),
              1e-3);
    EXPECT_LT(std::abs(*metrics.bars[3].measured_m - *good.bars[3].measured_m), 1e-3);
}

TEST(MeasureMarkersTest, AnIdThatLiesInTwoPlacesIsTold) {
    MarkerSwim swim(5);
    auto views = swim.views(0.1);
    for (TagView& view : views)
        if (view.id == 1) view.id = 4;

    EXPECT_THAT(codes(measure_markers(views, swim.plan(), swim.world())),
                testing::IsSupersetOf(
                    {"marker_in_two_places", "marker_seen_too_few", "scale_bar_not_measured"}));
}

TEST(MeasureMarkersTest, ATagSeenTwiceIsToldAndNotMeasured) {
    MarkerSwim swim(3);
    auto views = swim.views(0.1);
    std::erase_if(views, [](const TagView& view) { return view.id == 2 && view.keyframe > 7; });
    std::erase_if(views, [](const TagView& view) { return view.id == 2 && view.keyframe < 6; });

    const auto metrics = measure_markers(views, swim.plan(), swim.world());

    EXPECT_EQ(metrics.markers.size(), 2U);
    EXPECT_FALSE(metrics.bars[1].measured_m);
    EXPECT_THAT(codes(metrics), testing::Contains("marker_seen_too_few"));
}

BarMetrics bar(double known_m, double measured_m, double sigma_m) {
    BarMetrics bar;
    bar.known_m = known_m;
    bar.measured_m = measured_m;
    bar.own_sigma_m = sigma_m;
    bar.consistent = true;
    return bar;
}

// Worked out by hand: bars of 1, 2 and 0.5 m, measured as 1.01, 2.00 and 0.51 m, sigmas 1, 2 and 1
// mm; weights 1, 1/4, 1. Sum of w m k: 1.01 + 1.00 + 0.255 = 2.265; of w m m: 1.0201 + 1 + 0.2601
// = 2.2802. All: 0.9933339181. Without the first: 1.255 / 1.2601 = 0.9959527022; without the
// second: 1.265 / 1.2802 = 0.9881268552; without the third: 2.01 / 2.0201 = 0.9950002475.
TEST(MeasureBarsTest, LeaveOneOutIsTheErrorWithTheScaleOfTheOthers) {
    std::vector<BarMetrics> bars = {
        bar(1.0, 1.01, 1e-3), bar(2.0, 2.0, 2e-3), bar(0.5, 0.51, 1e-3)};

    leave_each_out(bars);

    EXPECT_NEAR(*bars[0].leave_one_out_error_m, 0.9959527022 * 1.01 - 1.0, 1e-8);
    EXPECT_NEAR(*bars[1].leave_one_out_error_m, 0.9881268552 * 2.0 - 2.0, 1e-8);
    EXPECT_NEAR(*bars[2].leave_one_out_error_m, 0.9950002475 * 0.51 - 0.5, 1e-8);
    EXPECT_NEAR(scale_of(bars)->factor, 0.9933339181, 1e-8);
}

TEST(MeasureBarsTest, ABarThatIsWrongIsToldAndTheScaleIsOfTheOthers) {
    MarkerSwim swim(6);
    dive::MarkerPlan plan = swim.plan();
    plan.scale_bars[2].distance_m += 0.02;

    const auto metrics = measure_markers(swim.views(0.1), plan, swim.world());

    ASSERT_EQ(metrics.bars.size(), plan.scale_bars.size());
    for (std::size_t i = 0; i < metrics.bars.size(); ++i)
        EXPECT_EQ(metrics.bars[i].consistent, i != 2) << i;
    EXPECT_NEAR(metrics.scale->factor, 1.0, 2e-3);
    EXPECT_THAT(codes(metrics), testing::ElementsAre("scale_bar_inconsistent"));
}

BarMetrics printed(double known_m, double measured_m, double known_sigma_m) {
    BarMetrics size = bar(known_m, measured_m, std::hypot(1e-4, known_sigma_m));
    size.is_printed_size = true;
    size.known_sigma_m = known_sigma_m;
    return size;
}

// Six tags of 160 mm that a printer made 3 % smaller.
TEST(MeasureBarsTest, SizesThatNobodyMeasuredOnThePrintScaleNothingUnasked) {
    std::vector<BarMetrics> bars(6, printed(0.16, 0.97 * 0.16, 0.0));
    EXPECT_NEAR(scale_of(bars)->factor, 1.0 / 0.97, 1e-9);
    const auto alone = trusted_scale(bars);
    ASSERT_TRUE(alone);
    EXPECT_LT(std::abs(alone->factor - 1.0), 3.0 * alone->sigma);

    bars.push_back(bar(0.5, 0.5, 1e-3));
    const auto beside_a_bar = trusted_scale(bars);
    EXPECT_NEAR(beside_a_bar->factor, 1.0, 1e-9);
    EXPECT_EQ(beside_a_bar->num_bars, 1);

    const std::vector<BarMetrics> stated(6, printed(0.16, 0.97 * 0.16, 2e-4));
    EXPECT_NEAR(trusted_scale(stated)->factor, 1.0 / 0.97, 1e-9);
    EXPECT_LT(trusted_scale(stated)->sigma, 1e-3);
    EXPECT_FALSE(trusted_scale({}));
}

TEST(MeasureBarsTest, AWorldThatIsOnePercentTooSmallIsToldAndScaled) {
    MarkerSwim swim(6);
    const auto views = swim.views(0.05);
    types::Trajectory trajectory(1);
    trajectory[0].T_world_imu = swim.keyframes()[0].T_world_cam;
    const WorldScale smaller(0.99, Eigen::Isometry3d::Identity());
    swim.keyframes() = smaller.applied(swim.keyframes(), trajectory);
    swim.rig().baseline_m *= 0.99;

    const auto metrics = measure_markers(views, swim.plan(), swim.world());

    EXPECT_NEAR(metrics.scale->factor, 1.0 / 0.99, 1e-3);
    EXPECT_THAT(codes(metrics), testing::ElementsAre("scale_off"));
    const WorldScale larger(metrics.scale->factor, Eigen::Isometry3d::Identity());
    swim.keyframes() = larger.applied(swim.keyframes(), trajectory);
    swim.rig().baseline_m *= metrics.scale->factor;
    const auto corrected = measure_markers(views, swim.plan(), swim.world());
    EXPECT_NEAR(corrected.scale->factor, 1.0, 1e-9);
    ASSERT_EQ(corrected.bars.size(), 5U);
    for (const BarMetrics& of_bar : corrected.bars) EXPECT_LT(std::abs(of_bar.error_m()), 1e-3);
    EXPECT_TRUE(corrected.findings.empty());
}

// If world and baseline are scaled by the same factor, the cameras see the same, whatever the lever
// arm of the body. The first pose stays.
TEST(WorldScaleTest, MovesCamerasAndLeavesTheArmOfTheBody) {
    Eigen::Isometry3d T_imu_cam = looking_down({0.1, -0.2, 0.05}, 0.4, 0.2);
    types::Trajectory trajectory(2);
    trajectory[0].T_world_imu = looking_down({1, 2, 3}, 0.1, 0.0);
    trajectory[1].T_world_imu = looking_down({2, 4, 3.5}, 0.9, 0.3);

    const types::Trajectory scaled = WorldScale(1.1, T_imu_cam).applied(trajectory);

    EXPECT_TRUE(scaled[0].T_world_imu.isApprox(trajectory[0].T_world_imu, 1e-12));
    const auto cameras = [&](const types::Trajectory& poses) {
        return Eigen::Vector3d(((poses[1].T_world_imu * T_imu_cam).translation() -
                                (poses[0].T_world_imu * T_imu_cam).translation()));
    };
    EXPECT_TRUE(cameras(scaled).isApprox(1.1 * cameras(trajectory), 1e-12));
    EXPECT_TRUE(scaled[1].T_world_imu.linear().isApprox(trajectory[1].T_world_imu.linear()));
}

TEST(WorldScaleTest, TheRigOfAScaledReconstructionHasItsBaseline) {
    types::Rig rig;
    rig.T_imu_cam0.translation() = Eigen::Vector3d(1.0, 0.0, 0.0);
    rig.T_imu_cam1.translation() = Eigen::Vector3d(1.2, 0.0, 0.0);

    const types::Rig scaled =
        rig_as_scaled(rig, {{"markers", {{"scale_correction", {{"factor", 1.5}}}}}});

    EXPECT_NEAR(scaled.baseline_m(), 0.3, 1e-12);
    EXPECT_EQ(scaled.T_imu_cam0.translation(), rig.T_imu_cam0.translation());
    EXPECT_EQ(rig_as_scaled(rig, {{"markers", nlohmann::json::object()}}).baseline_m(),
              rig.baseline_m());
}

}  // namespace
}  // namespace divemesh::markers
