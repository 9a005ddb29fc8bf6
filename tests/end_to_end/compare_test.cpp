// Two dives of one place, compared by a server and its worker.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <fstream>

#include "tests/end_to_end/service.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
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
    Outcome compare(const std::string& a,
                    const std::string& b,
                    const std::vector<std::string>& more = {}) {
        std::vector<std::string> words = {
            "compare", a, b, "--server", service.address(), "--out", out.string(), "--json"};
        words.insert(words.end(), more.begin(), more.end());
        return service.run(words, 300s);
    }
    // A square of 0.2 m about the middle of the patch that changed the most, as it would be drawn
    // on either model.
    std::string square(const json& change, bool on_the_later) {
        const json& fit = change.at("registration").at("T_a_b");
        const auto q = fit.at("orientation_wxyz").get<std::array<double, 4>>();
        const auto p = fit.at("position_m").get<std::array<double, 3>>();
        Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
        T_a_b.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
        T_a_b.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
        const auto middle = change.at("patches")[0].at("center_m").get<std::array<double, 2>>();
        json corners = json::array();
        for (const auto& [x, y] : {std::pair{-0.1, -0.1},
                                   std::pair{0.1, -0.1},
                                   std::pair{0.1, 0.1},
                                   std::pair{-0.1, 0.1}}) {
            Eigen::Vector3d corner(middle[0] + x, middle[1] + y, 0.0);
            if (on_the_later) corner = T_a_b.inverse() * corner;
            corners.push_back({corner.x(), corner.y(), corner.z()});
        }
        const fs::path file = service / (on_the_later ? "later.json" : "areas.json");
        std::ofstream(file) << json{
            {"areas", {{{"name", "c1"}, {"label", "coral"}, {"polygon", corners}}}}};
        return file.string();
    }
    // Returns how the number of the label has changed.
    static json count_of(const json& change) {
        for (const json& metric : change.at("areas").at("figures"))
            if (metric.at("figure") == "count") return metric;
        return {};
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

    // The same again with outlines of both years, which the server is sent.
    const Outcome of_one = compare(before, after, {"--areas", square(change, false)});
    ASSERT_EQ(of_one.exit_code, 0) << of_one.err;
    EXPECT_TRUE(count_of(json::parse(of_one.out)).contains("refused"));
    const Outcome of_both = compare(
        before, after, {"--areas", square(change, false), "--later-areas", square(change, true)});
    ASSERT_EQ(of_both.exit_code, 0) << of_both.err;
    const json both = json::parse(of_both.out);
    EXPECT_EQ(both.at("areas").at("areas")[0].at("same_as"), "c1");
    EXPECT_EQ(count_of(both).at("later").at("value"), 1.0);
    EXPECT_EQ(count_of(both).at("change").at("value"), 0.0);
    EXPECT_TRUE(fs::exists(out / "area_changes.csv"));
    EXPECT_EQ(service.rest().list("/api/v1/dives/" + after + "/truth", {}).size(), 1U);
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
