// Two dives of one place, compared by a server and its worker.
#include <gtest/gtest.h>

#include "tests/end_to_end/service.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// The same reef a year apart, swum on two paths: corals grew, some are gone.
fs::path reef(int year) {
    // clang-format off
    return simulated_dive({"--scene", "reef", "--length-m", "1", "--rate", "5",
                           "--width-px", "320", "--height-px", "240", "--water", "none",
                           "--year", std::to_string(year), "--survey", std::to_string(year)});
    // clang-format on
}

class CompareEndToEndTest : public testing::Test {
protected:
    std::string upload(const fs::path& dive) {
        const Outcome sent = service.run({"upload", dive.string(), "--no-job", "--json"}, 60s);
        EXPECT_EQ(sent.exit_code, 0) << sent.err;
        return nlohmann::json::parse(sent.out).at("dive").get<std::string>();
    }
    Outcome compare(const std::string& a, const std::string& b) {
        return service.run(
            {"compare", a, b, "--server", service.address(), "--out", out.string(), "--json"},
            300s);
    }

    Service service;
    const fs::path out = service / "change";
};

TEST_F(CompareEndToEndTest, TwoYearsOfAReefAreReconstructedLaidOverEachOtherAndMeasured) {
    service.start_server(1);
    const std::string before = upload(reef(1));
    const std::string after = upload(reef(2));
    const Outcome outcome = compare(before, after);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto change = nlohmann::json::parse(outcome.out);
    EXPECT_GT(change.at("registration").at("agreement"), 0.8);
    EXPECT_GT(change.at("ground").at("both_m2"), 1.0);
    for (const char* kind : {"grown", "lost"}) {
        const auto& volume = change.at(kind).at("volume_m3");
        EXPECT_LE(volume.at("low"), volume.at("value")) << kind;
        EXPECT_LE(volume.at("value"), volume.at("high")) << kind;
    }
    EXPECT_GE(change.at("grown").at("num_patches"), 1) << "a coral grew by half";
    for (const char* name : {"compare.json", "report.html"})
        EXPECT_TRUE(fs::exists(out / name)) << name;
    EXPECT_EQ(nlohmann::json::parse(read_text(out / "compare.json")), change);

    const auto jobs = service.rest().list("/api/v1/jobs", {{"dive_id", before}});
    std::map<std::string, int> kinds;
    for (const auto& job : jobs) ++kinds[job.at("kind").get<std::string>()];
    EXPECT_EQ(kinds,
              (std::map<std::string, int>{{"compare", 1}, {"intake", 1}, {"reconstruct", 1}}));
}

TEST_F(CompareEndToEndTest, ADiveThatIsNotThereIsRefusedBeforeAnyWork) {
    service.start_server(0);
    const Outcome outcome = compare(upload(reef(1)), "dive_none");
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("dive_none"), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(out / "compare.json"));
}

}  // namespace
}  // namespace divemesh
