// What a client asks before it sends work: the limits of the server and the options of a job.
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "schemas/reconstruction_options.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

TEST(InfoTest, TheDataHaveAnIdWhateverTheServersAddress) {
    const TemporaryFolder data;
    const auto id_at_a_new_port = [&data] {
        server::ServerConfig config;
        config.data = data.path();
        TestServer server(config);
        std::string token;
        std::ifstream(data.path() / "admin.token") >> token;
        return server.request("GET", "/api/v1/info", token).json()["data_id"].get<std::string>();
    };
    const std::string id = id_at_a_new_port();
    EXPECT_EQ(id.size(), 32U);
    EXPECT_EQ(id_at_a_new_port(), id);
}

TEST(InfoTest, StatesTheLimitsThatHold) {
    server::ServerConfig config;
    config.max_upload_bytes = 1'000'000;
    config.max_project_dives = 3;
    TestServer server(config);
    const json info = server.request("GET", "/api/v1/info", server.admin()).json();
    EXPECT_EQ(info["version"], DIVEMESH_VERSION);
    EXPECT_EQ(info["engine"], "sqlite");
    EXPECT_EQ(info["limits"]["max_upload_bytes"], 1'000'000);
    EXPECT_EQ(info["limits"]["max_project_dives"], 3);
    const auto too_large = server.request(
        "POST", "/api/v1/uploads", "", tus_headers(server.admin(), {{"Upload-Length", "1000001"}}));
    EXPECT_EQ(too_large.status, 413);
    EXPECT_EQ(server.request("GET", "/api/v1/info", "").status, 401);
}

class OptionsTest : public testing::Test {
protected:
    // Returns the options of a kind by their names.
    std::map<std::string, json> options_of(const std::string& kind) {
        const json answer = server.request("GET", "/api/v1/options", server.admin()).json();
        std::map<std::string, json> options;
        for (const json& item : answer["items"])
            if (item["kind"] == kind)
                for (const json& option : item["options"]) options[option["name"]] = option;
        return options;
    }
    int enqueue(const json& body) {
        return server.post_json("/api/v1/dives/" + dive + "/jobs", server.admin(), body).status;
    }

    TestServer server;
    const std::string dive = server.make_dive("default", std::string(64, 'a'));
};

TEST_F(OptionsTest, HasEveryOptionWithTheDefaultsOfEachPreset) {
    const auto options = options_of("reconstruct");
    for (const auto preset : kPresets) {
        const json defaults = options_to_json(preset_options(preset));
        EXPECT_EQ(options.size(), defaults.size());
        for (const auto& [name, value] : defaults.items())
            EXPECT_EQ(options.at(name)["defaults"][std::string(preset)], value) << name;
    }
    EXPECT_EQ(options.at("voxel_m")["unit"], "m");
    EXPECT_EQ(options.at("voxel_m")["zero"], "automatic");
    EXPECT_EQ(options.at("seed")["type"], "integer");
}

// A value just beyond a limit that is stated is refused, one at the limit is taken.
TEST_F(OptionsTest, StatesTheLimitsThatJobsAreHeldTo) {
    for (const auto& [name, option] : options_of("reconstruct")) {
        const auto with = [&, &name = name](const json& value) {
            return enqueue({{"preset", "standard"}, {"options", {{name, value}}}});
        };
        const double beyond = option["type"] == "integer" ? 1.0 : 1e-6;
        const auto number = [&, &option = option](double value) {
            return option["type"] == "integer" ? json(static_cast<std::int64_t>(value))
                                               : json(value);
        };
        if (!option["maximum"].is_null()) {
            EXPECT_LT(with(option["maximum"]), 300) << name;
            EXPECT_EQ(with(number(option["maximum"].get<double>() + beyond)), 400) << name;
        }
        if (!option["minimum"].is_null()) {
            EXPECT_EQ(with(option["minimum"]) < 300, option["above_minimum"] == false) << name;
            EXPECT_EQ(with(number(option["minimum"].get<double>() - beyond)), 400) << name;
        }
        if (option["zero"] != "") {
            EXPECT_LT(with(0), 300) << name;
        }
        if (!option["words"].empty()) {
            EXPECT_EQ(with("no such word"), 400) << name;
        }
    }
}

TEST_F(OptionsTest, KnowsThoseOfReportsAndComparisons) {
    const auto report = options_of("accuracy_report");
    EXPECT_TRUE(report.contains("require"));
    EXPECT_EQ(report.at("require")["type"], "array");
    const auto compare = options_of("compare");
    EXPECT_EQ(compare.at("cell_m")["maximum"], 1000);
    EXPECT_EQ(compare.at("least_area_m2")["unit"], "m²");
    EXPECT_EQ(enqueue({{"kind", "compare"}, {"options", {{"with", dive}, {"cell_m", 1001}}}}), 400);
}

}  // namespace
}  // namespace divemesh
