#include "worker/evaluation/known_distances.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "worker/camera/projection.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/evaluation/trajectory_pairs.hpp"

namespace divemesh::evaluation {
namespace {

// A rig with distorted lenses and cameras half a degree apart, 1.2 m above the floor z = 0. It
// looks down while it moves along x.
class KnownDistancesTest : public testing::Test {
protected:
    KnownDistancesTest() {
        rig_.cam0 = {640, 480, 490.0, 489.0, 321.0, 239.0};
        rig_.cam0.distortion_coefficients = {-0.12, 0.03, 4e-4, -3e-4};
        rig_.cam1 = rig_.cam0;
        rig_.cam1.cx_px = 318.0;
        rig_.T_imu_cam0.linear() =
            Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
        rig_.T_imu_cam0.translation() = Eigen::Vector3d(0.03, -0.02, 0.05);
        rig_.T_imu_cam1 = rig_.T_imu_cam0 * Eigen::Translation3d(0.12, 0.001, -0.002) *
                          Eigen::AngleAxisd(0.009, Eigen::Vector3d::UnitY());
        for (int i = 0; i < 10; ++i) {
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            pose.rotate(Eigen::AngleAxisd(0.02 * i, Eigen::Vector3d::UnitZ()));
            pose.translation() = Eigen::Vector3d(0.1 * i - 0.5, 0.02 * i, 1.2);
            truth_.push_back({i * std::int64_t{100'000'000}, pose});
            timestamps_ns_.push_back(i * std::int64_t{100'000'000});
        }
        add_square(floor_, 0.0F, 5.0F);
    }

    static void add_square(types::Mesh& mesh, float z, float half_side) {
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(),
                             {{-half_side, -half_side, z},
                              {half_side, -half_side, z},
                              {half_side, half_side, z},
                              {-half_side, half_side, z}});
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
    }
    KnownDistanceErrors measure(const std::vector<dive::KnownDistance>& known,
                                const types::Trajectory& trajectory) const {
        const SurfaceIndex reference(floor_);
        const MarkingInput truth{rig_, truth_, timestamps_ns_, reference};
        return measure_known_distances(known, &truth, rig_, {trajectory, {}});
    }

    dive::KnownDistance marked_bar() const;

    types::Rig rig_;
    types::Trajectory truth_;
    std::vector<std::int64_t> timestamps_ns_;
    types::Mesh floor_;
    const dive::KnownDistance bar_{
        "bar", {-0.2, 0.05, 0.0}, {0.2, -0.1, 0.0}, std::hypot(0.4, 0.15)};
};

TEST_F(KnownDistancesTest, AreExactWithThePosesOfTheTruthInAnyWorld) {
    types::Trajectory elsewhere = truth_;
    const Eigen::Isometry3d T = Eigen::Translation3d(3, 1, -2) *
                                Eigen::AngleAxisd(1.0, Eigen::Vector3d(1, 1, 0).normalized()) *
                                Eigen::Isometry3d::Identity();
    for (types::StampedPose& pose : elsewhere) pose.T_world_imu = T * pose.T_world_imu;
    const KnownDistanceErrors errors = measure({bar_}, elsewhere);
    ASSERT_TRUE(errors.distances[0].measured_m.has_value());
    EXPECT_NEAR(*errors.distances[0].measured_m, bar_.distance_m, 1e-7);
    EXPECT_NEAR(errors.scale_error, 0.0, 1e-7);
    EXPECT_EQ(errors.distances[0].num_keyframes_a, 10);
}

// Marks in images that were taken before and after a knock of the right camera.
TEST_F(KnownDistancesTest, MarksAreSeenByTheRightCameraAsItStandsAtTheirTime) {
    const Eigen::Vector3d p_world(0.1, 0.05, 0.0);
    types::Rig knocked = rig_;
    knocked.T_imu_cam1.rotate(Eigen::AngleAxisd(0.015, Eigen::Vector3d::UnitY()));
    std::vector<dive::Mark> marks;
    for (const types::StampedPose& pose : truth_) {
        const types::Rig& rig = pose.timestamp_ns < 500'000'000 ? rig_ : knocked;
        const auto left =
            camera::project(rig.cam0, (pose.T_world_imu * rig.T_imu_cam0).inverse() * p_world);
        const auto right =
            camera::project(rig.cam1, (pose.T_world_imu * rig.T_imu_cam1).inverse() * p_world);
        marks.push_back({pose.timestamp_ns, *left, right});
    }
    rig_.right_turns = {{.from_ns = 500'000'000, .rotation = {0.0, 0.015, 0.0}}};

    const auto point = triangulate(marks, rig_, truth_);

    ASSERT_TRUE(point);
    EXPECT_LT((*point - p_world).norm(), 1e-7);
}

TEST_F(KnownDistancesTest, ScaleErrorIsTheFactorBetweenMeasuredAndKnown) {
    dive::KnownDistance wrong = bar_;
    wrong.distance_m /= 1.02;  // so that the measured length is 2 % too long
    const KnownDistanceErrors errors = measure({wrong, wrong}, truth_);
    EXPECT_NEAR(errors.scale_error, 0.02, 1e-6);
    EXPECT_NEAR(errors.median_abs_error_m, bar_.distance_m * (1.0 - 1.0 / 1.02), 1e-6);
}

TEST_F(KnownDistancesTest, AnEndOutsideTheImagesIsNotMeasured) {
    dive::KnownDistance far = bar_;
    far.b_world = {4.0, 0.0, 0.0};
    const KnownDistanceErrors errors = measure({far, bar_}, truth_);
    EXPECT_FALSE(errors.distances[0].measured_m.has_value());
    EXPECT_EQ(errors.distances[0].num_keyframes_b, 0);
    EXPECT_EQ(errors.num_measured, 1);
    EXPECT_TRUE(to_metrics(errors)["distances"][0]["measured_m"].is_null());
}

TEST_F(KnownDistancesTest, AnEndUnderACoverIsNotMeasured) {
    add_square(floor_, 0.3F, 1.0F);
    const KnownDistanceErrors errors = measure({bar_}, truth_);
    EXPECT_EQ(errors.distances[0].num_keyframes_a, 0);
    EXPECT_EQ(errors.num_measured, 0);
    EXPECT_FALSE(to_metrics(errors).contains("scale_error"));
}

TEST_F(KnownDistancesTest, AnEndOffEverySurfaceIsNotMeasured) {
    dive::KnownDistance floating = bar_;
    floating.a_world.z() = 0.2;
    EXPECT_EQ(measure({floating}, truth_).distances[0].num_keyframes_a, 0);
}

TEST_F(KnownDistancesTest, ThreeKeyframesAreTooFew) {
    timestamps_ns_ = {0, 100'000'000, 200'000'000};
    const KnownDistanceErrors errors = measure({bar_}, truth_);
    EXPECT_EQ(errors.distances[0].num_keyframes_a, 3);
    EXPECT_FALSE(errors.distances[0].measured_m.has_value());
}

TEST_F(KnownDistancesTest, EndsMarkedByHandNeedNoTruth) {
    const auto marks_of = [&](const Eigen::Vector3d& p_world) {
        std::vector<dive::Mark> marks;
        for (const types::StampedPose& pose : truth_) {
            const auto left = camera::project(
                rig_.cam0, (pose.T_world_imu * rig_.T_imu_cam0).inverse() * p_world);
            const auto right = camera::project(
                rig_.cam1, (pose.T_world_imu * rig_.T_imu_cam1).inverse() * p_world);
            marks.push_back({pose.timestamp_ns, left.value(), right});
        }
        for (std::size_t i = 0; i < marks.size(); i += 2) marks[i].pixel_right.reset();
        return marks;
    };
    dive::KnownDistance marked{
        "bar", {}, {}, bar_.distance_m, marks_of(bar_.a_world), marks_of(bar_.b_world)};
    const auto measured_m = [&] {
        return measure_known_distances({marked}, nullptr, rig_, {truth_, {}})
            .distances[0]
            .measured_m;
    };
    EXPECT_NEAR(measured_m().value(), bar_.distance_m, 1e-7);

    marked.marks_a.resize(3);
    EXPECT_FALSE(measured_m().has_value());  // three frames are too few
}

TEST_F(KnownDistancesTest, MarksOfARollingShutterAreSeenFromWhereTheirRowWasRead) {
    constexpr double kReadout_s = 0.03;
    const auto marks_of = [&](const Eigen::Vector3d& p_world) {
        std::vector<dive::Mark> marks;
        for (const types::StampedPose& pose : truth_) {
            Eigen::Vector2d pixel(320.0, 240.0);
            for (int i = 0; i < 10; ++i) {
                const double late_s = kReadout_s * (pixel.y() / rig_.cam0.height_px - 0.5);
                const auto T_world_imu =
                    pose_at(truth_, pose.timestamp_ns + std::llround(1e9 * late_s));
                pixel =
                    camera::project(rig_.cam0, (*T_world_imu * rig_.T_imu_cam0).inverse() * p_world)
                        .value();
            }
            marks.push_back({pose.timestamp_ns, pixel, std::nullopt});
        }
        return marks;
    };
    const Eigen::Vector3d a(-0.1, 0.25, 0.0);
    const Eigen::Vector3d b(0.1, -0.25, 0.0);
    const std::vector<dive::KnownDistance> marked = {
        {"bar", {}, {}, (a - b).norm(), marks_of(a), marks_of(b)}};
    const auto error_m = [&](double readout_time_s) {
        const KnownPath path{
            .trajectory = truth_, .covariances = {}, .readout_time_s = readout_time_s};
        return std::abs(
            measure_known_distances(marked, nullptr, rig_, path).distances[0].measured_m.value() -
            marked[0].distance_m);
    };
    EXPECT_GT(error_m(0.0), 1e-3);
    EXPECT_LT(error_m(kReadout_s), 1e-5);
}

dive::KnownDistance KnownDistancesTest::marked_bar() const {
    const SurfaceIndex reference(floor_);
    const MarkingInput truth{rig_, truth_, timestamps_ns_, reference};
    dive::KnownDistance marked = bar_;
    marked.marks_a = mark_point(bar_.a_world, truth);
    marked.marks_b = mark_point(bar_.b_world, truth);
    return marked;
}

TEST_F(KnownDistancesTest, AreMeasuredWithinOneSegment) {
    types::Trajectory lost = truth_;
    types::TrackingSegment first{.num_frames = 4, .intervals = {{0, 300'000'000}}};
    types::TrackingSegment second{.num_frames = 6, .intervals = {{400'000'000, 900'000'000}}};
    for (std::size_t i = 4; i < lost.size(); ++i)
        lost[i].T_world_imu.pretranslate(Eigen::Vector3d(3.0, 0.5, 0.0));
    const auto measured = [&](const std::vector<types::TrackingSegment>& segments) {
        return measure_known_distances({marked_bar()}, nullptr, rig_, {lost, {}, 0.0, segments})
            .distances[0];
    };
    EXPECT_GT(std::abs(measured({}).measured_m.value() - bar_.distance_m), 0.01);
    EXPECT_NEAR(measured({first, second}).measured_m.value(), bar_.distance_m, 1e-7);
    EXPECT_EQ(measured({first, second}).num_keyframes_a, 6);
    // Three frames are too few in either part.
    first.intervals = {{0, 200'000'000}};
    second.intervals = {{700'000'000, 900'000'000}};
    EXPECT_FALSE(measured({first, second}).measured_m.has_value());
}

TEST_F(KnownDistancesTest, AreMeasuredInFramesThatShowBothEnds) {
    dive::KnownDistance marked = marked_bar();
    marked.marks_a.resize(7);
    marked.marks_b.erase(marked.marks_b.begin(), marked.marks_b.begin() + 3);
    types::Trajectory drifted = truth_;
    for (const std::size_t i : {0, 1, 2, 7, 8, 9})
        drifted[i].T_world_imu.pretranslate(Eigen::Vector3d(0.01, 0.0, 0.02));
    const MeasuredDistance measured =
        measure_known_distances({marked}, nullptr, rig_, {drifted, {}}).distances[0];
    EXPECT_NEAR(measured.measured_m.value(), bar_.distance_m, 1e-7);
    EXPECT_EQ(measured.num_keyframes_a, 4);
    EXPECT_EQ(measured.num_keyframes_b, 4);
}

TEST_F(KnownDistancesTest, MarksOfOtherTimesAreNotCounted) {
    dive::KnownDistance marked = bar_;
    marked.marks_a.assign(6, {-1, {320.0, 240.0}, std::nullopt});
    marked.marks_b = marked.marks_a;
    EXPECT_EQ(measure_known_distances({marked}, nullptr, rig_, {truth_, {}}).num_measured, 0);
}

// The path drifts between the views of the two ends, and the length is uncertain by that drift.
TEST_F(KnownDistancesTest, SigmaHoldsTheCalibrationAndTheDriftBetweenTheEnds) {
    types::CovarianceTrack known_well(2);
    known_well[1].timestamp_ns = 1'000'000'000;
    types::CovarianceTrack drifting = known_well;
    drifting[1].position_m2 = Eigen::Vector3d(0.0, 4e-4, 1e-4).asDiagonal();
    dive::KnownDistance marked = bar_;
    const SurfaceIndex reference(floor_);
    const MarkingInput truth{rig_, truth_, timestamps_ns_, reference};
    const auto marks_a = mark_point(bar_.a_world, truth), marks_b = mark_point(bar_.b_world, truth);
    marked.marks_a.assign(marks_a.begin(), marks_a.begin() + 4);  // 0 to 0.3 s
    marked.marks_b.assign(marks_b.end() - 4, marks_b.end());      // 0.6 to 0.9 s
    const auto sigma_m = [&](const types::CovarianceTrack& covariances) {
        return measure_known_distances({marked}, nullptr, rig_, {truth_, covariances, 0.001})
            .distances[0]
            .sigma_m;
    };
    EXPECT_FALSE(sigma_m({}).has_value());
    EXPECT_NEAR(sigma_m(known_well).value(), 0.001 * bar_.distance_m, 1e-8);
    // The variance increases by 4e-4 m2 per second, and the ends were seen 0.6 s apart.
    EXPECT_NEAR(sigma_m(drifting).value(),
                std::hypot(0.001 * bar_.distance_m, std::sqrt(0.6 * 4e-4)),
                1e-6);
}

// If another scale is right, the length is wrong by its share; that the path is wrong too is the
// same error.
TEST_F(KnownDistancesTest, SigmaReachesAScaleThatContradictsThePathOnce) {
    constexpr double kContradiction = 0.05;
    const double by_contradiction = contradiction_sigma(kContradiction);
    types::CovarianceTrack covariances;
    for (const types::StampedPose& pose : truth_)
        covariances.push_back(
            {pose.timestamp_ns, 1e-7 * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero()});
    covariances =
        with_scale_sigma(covariances, offsets_from_start(truth_, {}), 0.0, by_contradiction);
    dive::KnownDistance marked = marked_bar();
    marked.marks_a.resize(4);                                                // 0 to 0.3 s
    marked.marks_b.erase(marked.marks_b.begin(), marked.marks_b.end() - 4);  // 0.6 to 0.9 s
    const KnownPath path{.trajectory = truth_,
                         .covariances = covariances,
                         .scale_sigma = std::hypot(0.001, by_contradiction),
                         .contradiction_sigma = by_contradiction};
    const double sigma_m =
        measure_known_distances({marked}, nullptr, rig_, path).distances[0].sigma_m.value();
    EXPECT_GT(1.96 * sigma_m, kContradiction * bar_.distance_m);
    EXPECT_LT(1.96 * sigma_m, 1.05 * kContradiction * bar_.distance_m);
}

// With new noise of 0.3 px each time, sigma equals the scatter of the measured lengths.
TEST_F(KnownDistancesTest, SigmaIsTheScatterOfLengthsByNoisyMarks) {
    const types::CovarianceTrack known_well(1);
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 0.3);
    const SurfaceIndex reference(floor_);
    const MarkingInput truth{rig_, truth_, timestamps_ns_, reference};
    double squares_of_errors = 0.0, variances = 0.0;
    for (int i = 0; i < 400; ++i) {
        dive::KnownDistance marked = bar_;
        marked.marks_a = mark_point(bar_.a_world, truth);
        marked.marks_b = mark_point(bar_.b_world, truth);
        for (auto* marks : {&marked.marks_a, &marked.marks_b})
            for (dive::Mark& mark : *marks) {
                mark.pixel_left += Eigen::Vector2d(noise(random), noise(random));
                if (mark.pixel_right)
                    *mark.pixel_right += Eigen::Vector2d(noise(random), noise(random));
            }
        const auto measured =
            measure_known_distances({marked}, nullptr, rig_, {truth_, known_well}).distances[0];
        squares_of_errors += std::pow(measured.measured_m.value() - bar_.distance_m, 2);
        const double by_calibration = types::kCalibrationSigma * bar_.distance_m;
        variances += std::pow(measured.sigma_m.value(), 2) - by_calibration * by_calibration;
    }
    EXPECT_NEAR(std::sqrt(squares_of_errors / variances), 1.0, 0.15);
}

TEST_F(KnownDistancesTest, PixelNoiseLeavesThePointWhereItIsWithinItsShare) {
    const SurfaceIndex reference(floor_);
    std::vector<dive::Mark> marks =
        mark_point(bar_.a_world, MarkingInput{rig_, truth_, timestamps_ns_, reference});
    ASSERT_EQ(marks.size(), 10U);
    for (std::size_t i = 0; i < marks.size(); ++i)
        marks[i].pixel_left.x() += i % 2 == 0 ? 0.3 : -0.3;
    const auto point = triangulate(marks, rig_, truth_);
    ASSERT_TRUE(point.has_value());
    EXPECT_LT((*point - bar_.a_world).norm(), 1e-3);  // 0.3 px at 1.2 m are 0.7 mm
}

TEST_F(KnownDistancesTest, RaysThatMeetBehindTheCamerasGiveNoPoint) {
    const SurfaceIndex reference(floor_);
    std::vector<dive::Mark> marks =
        mark_point(bar_.a_world, MarkingInput{rig_, truth_, timestamps_ns_, reference});
    ASSERT_EQ(marks.size(), 10U);
    marks.erase(marks.begin() + 1, marks.end());
    const double disparity_px = marks[0].pixel_left.x() - marks[0].pixel_right->x();
    ASSERT_GT(disparity_px, 0.0);
    marks[0].pixel_right->x() += 2.0 * disparity_px;
    EXPECT_FALSE(triangulate(marks, rig_, truth_, 1));
}

}  // namespace
}  // namespace divemesh::evaluation
