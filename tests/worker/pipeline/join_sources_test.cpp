#include "worker/pipeline/join_sources.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "worker/base/hashed_random.hpp"
#include "worker/base/seconds.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kDuration_s = 240.0;
constexpr double kSpeed_m_s = 0.3;
constexpr double kSigma_m = 0.3;

// Returns where the body is after a time: lines of 12 m, half a metre apart.
Eigen::Vector3d place_at(double t_s) {
    const double s_m = kSpeed_m_s * t_s;
    const double line = std::floor(s_m / 12.0);
    const double along_m = s_m - 12.0 * line;
    return {std::fmod(line, 2.0) == 0.0 ? along_m : 12.0 - along_m, 0.5 * line, 0.0};
}

// A path without error, known to a millimetre.
PathToJoin exact_path() {
    types::PathPrior prior;
    std::vector<Eigen::Isometry3d> anchors;
    types::Trajectory trajectory;
    for (int i = 0; i <= 24; ++i) {
        const double t_s = i * kDuration_s / 24.0;
        prior.timestamps_ns.push_back(base::to_ns(t_s));
        prior.apart_m.push_back(0.0);
        anchors.emplace_back(Eigen::Translation3d(place_at(t_s)));
    }
    const auto size = 6 * std::ssize(anchors);
    prior.drift = 1e-6 * Eigen::MatrixXd::Identity(size, size);
    prior.drift.topLeftCorner<6, 6>().setZero();
    prior.shared = Eigen::MatrixXd::Zero(size, 1);
    return {prior, optimisation::AnchoredPath(prior.timestamps_ns, anchors, {}), trajectory};
}

// Returns positions once in two seconds by a clock that is `clock_s` ahead, with the coordinates as
// `alter` changes them.
PointsAt positions(double clock_s, std::function<void(std::size_t, Eigen::Vector3d&)> alter) {
    return [=](double later_s) {
        base::RandomRow random(7);
        SourcePoints source;
        source.agreement.name = "position0";
        source.agreement.kind = "usbl";
        std::size_t i = 0;
        for (double t_s = 0.0; t_s <= kDuration_s; t_s += 2.0) {
            Eigen::Vector3d p_site =
                Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) * place_at(t_s);
            for (int axis = 0; axis < 3; ++axis) p_site[axis] += kSigma_m * random.gaussian();
            alter(i++, p_site);
            const double stamped_s = t_s + clock_s + later_s;
            ++source.agreement.num_rows;
            if (stamped_s < 0.0 || stamped_s > kDuration_s)
                ++source.agreement.num_without_path;
            else
                source.points.push_back(
                    {base::to_ns(stamped_s), place_at(stamped_s), p_site, kSigma_m, kSigma_m});
        }
        return std::vector{source};
    };
}

types::SourceAgreement agreement_of(const PointsAt& points_at) {
    return join_sources(exact_path(), points_at, {}, {}).sources.at(0);
}

const auto kAsMeasured = [](std::size_t, Eigen::Vector3d&) {};

TEST(JoinSourcesTest, PositionsThatFitAreUsedWithTheirSigma) {
    const PathToJoin path = exact_path();
    const JoinedSources found = join_sources(path, positions(0.0, kAsMeasured), {}, {});
    ASSERT_TRUE(found.joined.converged);
    const types::SourceAgreement& agreement = found.sources.at(0);
    EXPECT_EQ(agreement.left_out, "");
    EXPECT_GE(agreement.num_used(), 119);
    EXPECT_LT(agreement.sigma_factor, 1.2);
    EXPECT_NEAR(agreement.rms_m, kSigma_m * std::numbers::sqrt2, 0.06);
    const double heading = std::atan2(found.joined.T_site_world.linear()(1, 0),
                                      found.joined.T_site_world.linear()(0, 0));
    EXPECT_NEAR(heading, 0.7, 3.0 * std::sqrt(found.joined.site_covariance(2, 2)));
}

TEST(JoinSourcesTest, OutliersAreCountedAndDoNotCount) {
    const auto agreement = agreement_of(positions(0.0, [](std::size_t i, Eigen::Vector3d& p) {
        if (i % 5 == 0) p.y() += 20.0;
    }));
    EXPECT_EQ(agreement.left_out, "");
    EXPECT_EQ(agreement.num_rejected, 25);
}

TEST(JoinSourcesTest, AnotherClockIsNamedAndNotCorrected) {
    const auto agreement = agreement_of(positions(15.0, kAsMeasured));
    EXPECT_NE(agreement.left_out.find("clock is 15 s ahead of"), std::string::npos)
        << agreement.left_out;
    EXPECT_EQ(agreement.num_used(), 0);
}

TEST(JoinSourcesTest, ExchangedCoordinatesAreNamed) {
    const auto agreement = agreement_of(
        positions(0.0, [](std::size_t, Eigen::Vector3d& p) { std::swap(p.x(), p.y()); }));
    EXPECT_NE(agreement.left_out.find("mirrored"), std::string::npos) << agreement.left_out;
}

TEST(JoinSourcesTest, SigmasThatAreTooSmallGrowToWhatIsSeen) {
    const auto agreement = agreement_of(positions(0.0, [](std::size_t i, Eigen::Vector3d& p) {
        base::RandomRow own(100 + i);
        p += 0.6 * Eigen::Vector3d(own.gaussian(), own.gaussian(), 0.0);
    }));
    EXPECT_EQ(agreement.left_out, "");
    EXPECT_NEAR(agreement.sigma_factor, std::hypot(0.3, 0.6) / 0.3, 0.5);
}

TEST(JoinSourcesTest, APathIsBentAsFarAsPositionsShowThatItsSigmasAreTooSmall) {
    PathToJoin bent = exact_path();
    std::vector<Eigen::Isometry3d> anchors;
    for (std::size_t i = 0; i < bent.path.size(); ++i) {
        Eigen::Isometry3d T = bent.path.T_world_imu(i);
        T.translation().y() +=
            0.02 * std::pow(static_cast<double>(i), 2) / 2.0;  // 5.8 m in the end
        anchors.push_back(T);
    }
    for (Eigen::Index i = 1; i < std::ssize(anchors); ++i)  // a walk of a decimetre
        for (Eigen::Index j = 1; j < std::ssize(anchors); ++j)
            bent.prior.drift.block<3, 3>(6 * i, 6 * j) =
                0.01 * static_cast<double>(std::min(i, j)) * Eigen::Matrix3d::Identity();
    bent.path = optimisation::AnchoredPath(bent.prior.timestamps_ns, anchors, {});
    const auto as_bent = [&](double later_s) {
        auto sources = positions(0.0, kAsMeasured)(later_s);
        for (optimisation::OutsidePoint& point : sources[0].points) {
            const double i = 24.0 * base::to_s(point.timestamp_ns) / kDuration_s;
            point.p_world.y() += 0.02 * i * i / 2.0;
        }
        return sources;
    };
    const JoinedSources found = join_sources(bent, as_bent, {}, {});
    ASSERT_TRUE(found.joined.converged);
    EXPECT_EQ(found.sources.at(0).left_out, "");
    EXPECT_GT(found.prior_factor, 1.5);
    const Eigen::Vector3d end =
        found.joined.T_new_old.back() * anchors.back().translation() - place_at(kDuration_s);
    EXPECT_LT(end.norm(), 1.0);
}

TEST(JoinSourcesTest, PositionsOfAnotherPlaceAreLeftOut) {
    const auto agreement = agreement_of(positions(0.0, [](std::size_t i, Eigen::Vector3d& p) {
        base::RandomRow own(200 + i);
        p = Eigen::Vector3d(own.uniform(0.0, 40.0), own.uniform(0.0, 40.0), 0.0);
    }));
    EXPECT_NE(agreement.left_out, "");
    EXPECT_FALSE(join_sources(exact_path(),
                              positions(0.0,
                                        [](std::size_t i, Eigen::Vector3d& p) {
                                            base::RandomRow own(200 + i);
                                            p = Eigen::Vector3d(own.uniform(0.0, 40.0),
                                                                own.uniform(0.0, 40.0),
                                                                0.0);
                                        }),
                              {},
                              {})
                     .joined.converged);
}

}  // namespace
}  // namespace divemesh::pipeline
