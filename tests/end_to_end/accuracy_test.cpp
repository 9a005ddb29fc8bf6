// A report as its users ask for it: truth sent later, requirements, exit codes.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "api/client/rest_client.hpp"
#include "tests/end_to_end/service.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class AccuracyEndToEndTest : public testing::Test {
protected:
    // Uploads a dive, which is reconstructed.
    std::string upload() {
        const Outcome sent =
            service.run({"upload", small_dive().string(), "--wait", "--json"}, 300s);
        EXPECT_EQ(sent.exit_code, 0) << sent.err;
        return nlohmann::json::parse(sent.out).at("dive").get<std::string>();
    }
    Outcome report(const std::string& subject, std::vector<std::string> more) {
        more.insert(more.begin(), {"report", subject, "--server", service.address()});
        return service.run(more, 200s);
    }
    nlohmann::json get(const std::string& path) { return service.rest().get(path); }

    Service service;
};

TEST_F(AccuracyEndToEndTest, AReportPassesOrFailsByWhatIsRequiredOfIt) {
    service.start_server(1);
    const std::string dive = upload();
    const fs::path out = service / "report";
    const fs::path junit = service / "junit.xml";
    const Outcome met = report(
        dive, {"--require", "ate_rmse_m<=0.05", "--out", out.string(), "--junit", junit.string()});
    EXPECT_EQ(met.exit_code, 0) << met.err;
    for (const char* name : {"report.json", "report.csv", "report.html", "junit.xml"})
        EXPECT_TRUE(fs::exists(out / name)) << name;
    EXPECT_EQ(read_text(junit), read_text(out / "junit.xml"));
    EXPECT_NE(read_text(junit).find("failures=\"0\""), std::string::npos) << read_text(junit);

    const Outcome hollow = report(dive, {"--require", "drift_percent<=0.5", "--json"});
    EXPECT_EQ(hollow.exit_code, 3) << "a path of one metre has no segment to take it over";
    const auto reason = nlohmann::json::parse(hollow.out).at("requirements").at(0).at("reason");
    EXPECT_NE(reason.get<std::string>().find("segment"), std::string::npos) << reason;

    const Outcome unmet = report(dive, {"--require", "ate_rmse_m<=1e-9", "--json"});
    EXPECT_EQ(unmet.exit_code, 3) << unmet.err;
    EXPECT_EQ(nlohmann::json::parse(unmet.out).at("passed"), false);
    EXPECT_EQ(report(dive, {"--require", "beauty<=1"}).exit_code, 2);
    EXPECT_EQ(report("dive_none", {}).exit_code, 1);

    const auto series = get("/api/v1/metrics?metric=ate_rmse_m&kind=accuracy_report");
    EXPECT_EQ(series.at("items").size(), 3U);
    EXPECT_EQ(series.at("unit"), "m");
}

TEST_F(AccuracyEndToEndTest, TruthThatIsSentLaterIsWhatAReportMeasuresAgainst) {
    service.start_server(1);
    const std::string dive = upload();
    const fs::path truth = small_dive() / "mav0/state_groundtruth_estimate0/data.csv";
    const auto with_truth = [&] {
        return report(dive, {"--ground-truth", truth.string(), "--json"});
    };
    const Outcome first = with_truth();
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const auto measured = nlohmann::json::parse(first.out);
    EXPECT_EQ(measured.at("truth").at("format"), "euroc");
    EXPECT_NE(measured.at("truth").at("source"), "dive");
    EXPECT_EQ(with_truth().exit_code, 0);
    EXPECT_EQ(get("/api/v1/dives/" + dive + "/truth").at("items").size(), 1U) << "sent once";
}

TEST_F(AccuracyEndToEndTest, TruthThatIsBrokenIsLeftAsideAndTheReportSaysSo) {
    service.start_server(1);
    const std::string dive = upload();
    const fs::path broken = service / "broken.tum";
    std::ofstream(broken) << "1.0 2 3 4 0 0 0 1\n2.0 2 3 here 0 0 0 1\n";
    const Outcome named = report(dive, {"--ground-truth", broken.string()});
    EXPECT_EQ(named.exit_code, 1);
    EXPECT_NE(named.err.find("broken.tum:2:"), std::string::npos) << named.err;
    EXPECT_NE(named.err.find("correct that file"), std::string::npos) << named.err;
    const Outcome unnamed = report(dive, {"--json"});
    ASSERT_EQ(unnamed.exit_code, 0) << unnamed.err;
    const auto measured = nlohmann::json::parse(unnamed.out);
    EXPECT_EQ(measured.at("truth").at("source"), "dive");
    const auto& findings = measured.at("findings");
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings.at(0).at("code"), "truth_set_aside");
    EXPECT_EQ(findings.at(0).at("where"), "broken.tum");
    EXPECT_NE(service.run({"dives", dive}).out.find("cannot be read"), std::string::npos);
}

TEST_F(AccuracyEndToEndTest, SchedulesAreMadeListedAndRemoved) {
    service.start_server(0);
    const auto add = [&](const std::string& cron, const std::string& requirement) {
        return service.run({"schedules",
                            "add",
                            "--cron",
                            cron,
                            "--tag",
                            "reference",
                            "--require",
                            requirement,
                            "--json"});
    };
    const Outcome made = add("30 4 * * mon", "drift_percent<=0.5");
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const auto id = nlohmann::json::parse(made.out).at("id").get<std::string>();
    EXPECT_NE(service.run({"schedules", "list"}).out.find(id), std::string::npos);
    EXPECT_EQ(add("every monday", "drift_percent<=0.5").exit_code, 2);
    EXPECT_EQ(add("30 4 * * mon", "beauty<=1").exit_code, 2);
    EXPECT_EQ(service.run({"schedules", "remove", id}).exit_code, 0);
    EXPECT_EQ(service.run({"schedules", "remove", id}).exit_code, 1);
    EXPECT_EQ(service.run({"schedules", "list", "--json"}).out, "[]\n");
}

}  // namespace
}  // namespace divemesh
