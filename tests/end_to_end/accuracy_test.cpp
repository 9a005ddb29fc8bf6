// A report as its users ask for it: truth sent later, requirements, exit codes.
#include <gtest/gtest.h>

#include <filesystem>

#include "api/client/rest_client.hpp"
#include "tests/end_to_end/service.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class AccuracyEndToEndTest : public testing::Test {
protected:
    // Of a dive that is reconstructed.
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
    nlohmann::json get(const std::string& path) {
        api::client::RestClient rest(
            {api::client::parse_server_url(service.address()), service.token()});
        return rest.get(path);
    }

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

    const Outcome unmet = report(dive, {"--require", "ate_rmse_m<=1e-9", "--json"});
    EXPECT_EQ(unmet.exit_code, 3) << unmet.err;
    EXPECT_EQ(nlohmann::json::parse(unmet.out).at("passed"), false);
    EXPECT_EQ(report(dive, {"--require", "beauty<=1"}).exit_code, 2);
    EXPECT_EQ(report("dive_none", {}).exit_code, 1);

    const auto series = get("/api/v1/metrics?metric=ate_rmse_m&kind=accuracy_report");
    EXPECT_EQ(series.at("items").size(), 2U);
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

}  // namespace
}  // namespace divemesh
