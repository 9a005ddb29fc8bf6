#include "storage/metric_store.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "storage/dive_removal.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

constexpr const char* kAte = "trajectory.final.ate_rmse_m";

class MetricStoreTest : public StoreTest {
protected:
    Dive dive_of(const std::string& name, const IntakeResult& intake) {
        const Dive dive = create_dive(name).dive;
        finish_intake(dive, intake);
        return dives_.get(dive.id);
    }
    Job succeed(const Measurement& measured) {
        const Claim done = claim();
        EXPECT_TRUE(jobs_.succeed(done.lease, {}, measured));
        return jobs_.get(done.job.id);
    }
    static Measurement ate(double value) {
        return {.metrics = {{kAte, value, "m", "RMS"}}, .version = "1", .calibration_sha256 = "c"};
    }
    Job reconstruct(const Dive& dive, double value) {
        enqueue(dive);
        return succeed(ate(value));
    }
    // Reports on the newest reconstruction of a dive.
    Job report(const Dive& dive, const Measurement& measured, const std::string& tag = "") {
        nlohmann::json options = {{"by", ++num_reports_}};
        if (!tag.empty()) options["tag"] = tag;
        jobs_.enqueue({.dive_id = dive.id, .kind = JobKind::AccuracyReport, .options = options});
        return succeed(measured);
    }
    std::vector<double> values(MetricFilter filter) {
        if (filter.metric.empty()) filter.metric = kAte;
        std::vector<double> found;
        for (const auto& point : metrics_.series(filter, {}).items) found.push_back(point.value);
        return found;
    }
    std::map<std::string, std::vector<double>> history(const Job& job) {
        return jobs_.inputs(job).history;
    }

    MetricStore metrics_{catalog_};
    int num_reports_ = 0;
};

using Values = std::vector<double>;

TEST_F(MetricStoreTest, ASeriesIsNarrowedByWhatTheDiveIs) {
    const Dive a = dive_of("a", {.site = "bay", .rig = "aqua", .tags = {"yearly"}});
    const Dive b = dive_of("b", {.site = "bay", .rig = "other"});
    const Job first = reconstruct(a, 0.1);
    reconstruct(b, 0.2);
    reconstruct(a, 0.3);
    EXPECT_EQ(values({}), (Values{0.1, 0.2, 0.3}));
    EXPECT_EQ(values({.dive_id = a.id}), (Values{0.1, 0.3}));
    EXPECT_EQ(values({.site = "bay"}), (Values{0.1, 0.2, 0.3}));
    EXPECT_EQ(values({.rig = "other"}), (Values{0.2}));
    EXPECT_EQ(values({.tag = "yearly"}), (Values{0.1, 0.3}));
    EXPECT_EQ(values({.site = "bay", .rig = "aqua", .tag = "yearly"}), (Values{0.1, 0.3}));
    EXPECT_EQ(values({.project = "others"}), Values{});
    EXPECT_EQ(values({.project = "default", .kind = JobKind::AccuracyReport}), Values{});
    EXPECT_EQ(values({.metric = "mesh.num_vertices"}), Values{});
    EXPECT_EQ(values({.since_ms = first.finished_at_ms + 1'000'000}), Values{});
    const MetricPoint point = metrics_.series({.metric = kAte}, {}).items[0];
    EXPECT_EQ(point.job_id, first.id);
    EXPECT_EQ(point.version, "1");
    EXPECT_EQ(point.calibration_sha256, "c");
    EXPECT_EQ(point.preset, "standard");
    EXPECT_EQ(metrics_.find(kAte)->unit, "m");
    EXPECT_FALSE(metrics_.find("mesh.num_vertices"));
}

TEST_F(MetricStoreTest, PagesGoOnWhereTheOneBeforeEnded) {
    const Dive dive = ready_dive();
    for (int i = 0; i < 5; ++i) reconstruct(dive, i);
    Values found;
    PageRequest page{.limit = 2};
    for (bool more = true; more; more = !page.cursor.empty()) {
        const auto part = metrics_.series({.metric = kAte}, page);
        for (const auto& point : part.items) found.push_back(point.value);
        page.cursor = part.next_cursor;
    }
    EXPECT_EQ(found, (Values{0, 1, 2, 3, 4}));
}

// What a child says may be anything.
TEST_F(MetricStoreTest, WhatIsNoMetricIsLeftOut) {
    enqueue(ready_dive());
    Measurement measured = ate(1.0);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const auto& [name, value, unit] :
         {std::tuple{std::string("nan"), nan, std::string("m")},
          std::tuple{std::string("inf"), 1.0 / 0.0, std::string("m")},
          std::tuple{std::string(), 1.0, std::string("m")},
          std::tuple{std::string(1000, 'x'), 1.0, std::string("m")},
          std::tuple{std::string("unit"), 1.0, std::string(1000, 'm')},
          std::tuple{std::string(kAte), 2.0, std::string("m")}})
        measured.metrics.push_back({name, value, unit, ""});
    for (int i = 0; i < 10'000; ++i)
        measured.metrics.push_back({"f" + std::to_string(i), 1.0, "m", std::string(2000, 'x')});
    succeed(measured);
    EXPECT_EQ(values({}), Values{1.0}) << "the first of a name";
    for (const char* name : {"nan", "inf", "unit", "f9999"})
        EXPECT_EQ(values({.metric = name}), Values{}) << name;
    EXPECT_EQ(values({.metric = "f4000"}), Values{1.0});
}

TEST_F(MetricStoreTest, AStaleLeaseWritesNone) {
    const TwoWorkers workers = overtaken_worker();
    EXPECT_FALSE(jobs_.succeed(workers.stale, {}, ate(1.0)));
    EXPECT_EQ(values({}), Values{});
    EXPECT_TRUE(jobs_.succeed(workers.winner, {}, ate(2.0)));
    EXPECT_EQ(values({}), Values{2.0});
}

TEST_F(MetricStoreTest, ARequirementDecidesTheVerdictAndNotTheState) {
    const Dive dive = ready_dive();
    reconstruct(dive, 0.1);
    Measurement measured = ate(0.1);
    measured.requirements = {{"ate_rmse_m<=1", kAte, 0.1, true, ""},
                             {"x<=1", "x", std::nullopt, false, "there is none"}};
    const Job job = report(dive, measured);
    EXPECT_EQ(job.state, JobState::Succeeded);
    EXPECT_EQ(verdict_of(job), "failed");
    ASSERT_EQ(job.requirements.size(), 2U);
    EXPECT_FALSE(job.requirements[1].value);
    measured.requirements.pop_back();
    EXPECT_EQ(verdict_of(report(dive, measured)), "passed");
    EXPECT_EQ(verdict_of(report(dive, ate(0.1))), "");
    EXPECT_EQ(event_types(job.id).back(), "job.state");
}

TEST_F(MetricStoreTest, ARegressionIsAnEvent) {
    const Dive dive = ready_dive();
    reconstruct(dive, 0.1);
    Measurement measured = ate(0.5);
    measured.regressions = {{kAte, 0.5, 0.1, 0.12, 7}};
    const Job job = report(dive, measured);
    EXPECT_EQ(event_types(job.id).back(), "job.figure_worse");
}

TEST_F(MetricStoreTest, AReportIsHeldAgainstEarlierReconstructionsOfItsDive) {
    const Dive dive = ready_dive();
    reconstruct(dive, 1.0);
    report(dive, ate(1.0));
    report(dive, ate(1.1));  // of the same reconstruction: this one counts
    reconstruct(dive, 2.0);
    report(dive, ate(2.0));
    reconstruct(dive, 3.0);
    const Job now = report(dive, ate(3.0));
    EXPECT_EQ(history(now)[kAte], (Values{1.1, 2.0})) << "but not against itself";
}

TEST_F(MetricStoreTest, AReportOfATagIsHeldAgainstItsDivesUntilItHasEnoughOfItsOwn) {
    const IntakeResult tagged{.tags = {"yearly"}};
    for (int i = 0; i < 6; ++i) {
        const Dive other = dive_of("other " + std::to_string(i), tagged);
        reconstruct(other, i);
        report(other, ate(i));
    }
    const Dive dive = dive_of("dive", tagged);
    reconstruct(dive, 10.0);
    const Job first = report(dive, ate(10.0), "yearly");
    EXPECT_EQ(history(first)[kAte], (Values{0, 1, 2, 3, 4, 5}));
    for (int i = 11; i <= 14; ++i) {
        reconstruct(dive, i);
        report(dive, ate(i));
    }
    reconstruct(dive, 15.0);
    const Job later = report(dive, ate(15.0), "yearly");
    EXPECT_EQ(history(later)[kAte], (Values{10, 11, 12, 13, 14}));
}

TEST_F(MetricStoreTest, MetricsGoWithTheirDive) {
    const Dive dive = ready_dive();
    const Dive stays = ready_dive("stays");
    reconstruct(dive, 0.1);
    reconstruct(stays, 0.2);
    DiveRemoval removal(catalog_);
    removal.remove(dive.id, kOver, [](const Dive&) {});
    EXPECT_TRUE(removal.forget(dive.id));
    EXPECT_EQ(values({}), Values{0.2});
}

}  // namespace
}  // namespace divemesh::storage
