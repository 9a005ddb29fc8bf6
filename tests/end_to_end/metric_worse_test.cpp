// A schedule's report finds a metric worse than its history, and a webhook tells of it.
#include <gtest/gtest.h>

#include <soci/soci.h>

#include "storage/catalog.hpp"
#include "tests/end_to_end/webhook_receiver.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr const char* kAte = "trajectory.final.ate_rmse_m";

class MetricWorseTest : public testing::Test {
protected:
    void SetUp() override {
        if (!WebhookReceiver::is_installed())
            GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
        receiver.emplace(service, 1, std::vector<std::string>{"job"});
        const Outcome sent =
            service.run({"upload", small_dive().string(), "--no-job", "--json"}, 60s);
        ASSERT_EQ(sent.exit_code, 0) << sent.err;
        dive = json::parse(sent.out).at("dive").get<std::string>();
    }
    // A reconstruction of the path alone.
    std::string reconstruct(json options) {
        options["surface"] = false;
        const auto job =
            service.rest().post("/api/v1/dives/" + dive + "/jobs",
                                {{"kind", "reconstruct"}, {"options", std::move(options)}});
        const std::string id = job.at("id").get<std::string>();
        EXPECT_EQ(service.run({"jobs", id, "--wait"}, 120s).exit_code, 0);
        return id;
    }
    void report() {
        EXPECT_EQ(service.run({"report", dive, "--server", service.address()}, 60s).exit_code, 0);
    }
    json scheduled_report() {
        json found;
        EXPECT_TRUE(wait_until(120s, [&] {
            for (const auto& job : service.jobs())
                if (job.at("options").contains("tag") && job.at("state") == "succeeded")
                    found = job;
            return !found.is_null();
        }));
        return found;
    }
    // The first time is up to a minute away: as if that had passed.
    void let_it_be_due(const std::string& schedule) {
        storage::Catalog catalog("sqlite://" + (service / "data/catalog.db").string());
        catalog.transaction([&](soci::session& session) {
            session << "UPDATE schedules SET next_run_ms = 1 WHERE id = :id", soci::use(schedule);
        });
    }

    Service service;
    std::optional<WebhookReceiver> receiver;
    std::string dive;
};

TEST_F(MetricWorseTest, AScheduledReportThatIsWorseThanItsHistoryIsToldByWebhook) {
    for (int i = 0; i < 3; ++i) {
        reconstruct({{"seed", i + 1}});
        report();
    }
    const std::string worse =
        reconstruct({{"estimator", "pairwise"}, {"stereo", "block"}, {"adjust_whole_dive", false}});
    const Outcome made =
        service.run({"schedules", "add", "--cron", "* * * * *", "--tag", "tank", "--json"}, 60s);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    let_it_be_due(json::parse(made.out).at("id").get<std::string>());
    const json job = scheduled_report();
    EXPECT_EQ(job.at("options").at("job"), worse);

    EXPECT_TRUE(receiver->hears("job.figure_worse", 30s)) << receiver->heard();
    const auto told = receiver->events("job.figure_worse");
    ASSERT_EQ(told.size(), 1U);
    EXPECT_EQ(told[0].at("job_id"), job.at("id"));
    EXPECT_EQ(told[0].at("dive_id"), dive);
    EXPECT_EQ(told[0].at("tag"), "tank");
    json ate;
    for (const json& regression : told[0].at("regressions"))
        if (regression.at("figure") == kAte) ate = regression;
    ASSERT_FALSE(ate.is_null()) << told[0].dump(2);
    EXPECT_EQ(ate.at("num_earlier"), 3);
    EXPECT_GT(ate.at("value"), ate.at("limit"));
    EXPECT_GT(ate.at("limit"), ate.at("median"));
    const auto report = service.rest().get("/api/v1/jobs/" + job.at("id").get<std::string>() +
                                           "/artifacts/report.json");
    EXPECT_EQ(report.at("regressions"), told[0].at("regressions"));

    const auto listed = service.run({"schedules", "list"}, 60s);
    EXPECT_NE(listed.out.find("* * * * *"), std::string::npos) << listed.out;
}

}  // namespace
}  // namespace divemesh
