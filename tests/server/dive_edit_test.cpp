// Editing how a dive is described; the recording stays as it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "storage/event_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

class DiveEditTest : public testing::Test {
protected:
    RawResponse edit(const json& patch, const std::string& tag = "*") {
        return server.request("PATCH",
                              dive,
                              writer,
                              {{"Content-Type", "application/merge-patch+json"}, {"If-Match", tag}},
                              patch.dump());
    }
    RawResponse get(const std::string& target) { return server.request("GET", target, writer); }
    // Returns the pointer of what is refused.
    std::string refused(const json& patch) {
        const auto answer = edit(patch);
        EXPECT_EQ(answer.status, 400) << patch;
        return answer.json()["errors"].at(0).value("pointer", "");
    }

    static storage::IntakeResult recording() {
        storage::IntakeResult result;
        result.name = "As recorded";
        result.site = "Reef";
        result.rig = "rig-1";
        result.tags = {"2026", "north"};
        return result;
    }

    TestServer server;
    const std::string writer = server.make_token("reef", {"dives:read", "dives:write"});
    const std::string dive =
        "/api/v1/dives/" + server.make_dive("reef", std::string(64, 'a'), recording());
    const json before = get(dive).json();
};

TEST_F(DiveEditTest, WhatIsEditedIsShownAndWhatWasRecordedIsKept) {
    const json position = {{"latitude_deg", 54.5}, {"longitude_deg", -8.25}};
    const auto edited = edit({{"site", "Reef 3"},
                              {"tags", {"south"}},
                              {"notes", "left eye fogged\nafter 10 min"},
                              {"position", position}});
    ASSERT_EQ(edited.status, 200) << edited.body;
    const json shown = get(dive).json();
    EXPECT_EQ(shown, edited.json());
    EXPECT_EQ(shown["site"], "Reef 3");
    EXPECT_EQ(shown["notes"], "left eye fogged\nafter 10 min");
    EXPECT_EQ(shown["position"], position);
    EXPECT_EQ(shown["name"], "As recorded");
    EXPECT_EQ(
        shown["recorded"],
        (json{
            {"site", "Reef"}, {"tags", {"2026", "north"}}, {"notes", ""}, {"position", nullptr}}));
    EXPECT_EQ(shown["archive_sha256"], before["archive_sha256"]);
    edit({{"site", "Reef 4"}});
    EXPECT_EQ(get(dive).json()["recorded"]["site"], "Reef") << "not the edit before";
}

TEST_F(DiveEditTest, NullTakesTheRecordedValueAgain) {
    edit({{"site", "Reef 3"}, {"rig", "rig-2"}, {"name", "Edited"}});
    EXPECT_EQ(edit({{"site", nullptr}, {"rig", "rig-1"}, {"notes", nullptr}}).status, 200);
    const json shown = get(dive).json();
    EXPECT_EQ(shown["site"], "Reef");
    EXPECT_EQ(shown["rig"], "rig-1");
    EXPECT_EQ(shown["recorded"], (json{{"name", "As recorded"}}));
    edit({{"name", nullptr}});
    EXPECT_EQ(get(dive).json(), before);
}

TEST_F(DiveEditTest, ListsFindTheDiveByWhatIsShown) {
    edit({{"site", "Reef 3"}, {"tags", {"south", "south"}}});
    const auto found = [&](const std::string& query) {
        return get("/api/v1/dives?" + query).json()["items"].size();
    };
    EXPECT_EQ(found("site=Reef%203"), 1U);
    EXPECT_EQ(found("site=Reef"), 0U);
    EXPECT_EQ(found("tag=south"), 1U);
    EXPECT_EQ(found("tag=north"), 0U);
}

TEST_F(DiveEditTest, ItIsEditedAsItWasRead) {
    const std::string tag = get(dive).header("etag");
    EXPECT_EQ(edit({{"site", "mine"}}, tag).status, 200);
    EXPECT_EQ(edit({{"site", "yours"}}, tag).status, 412);
    EXPECT_EQ(get(dive).json()["site"], "mine");
}

TEST_F(DiveEditTest, WhatCannotBeADescriptionIsRefusedWithItsPlace) {
    EXPECT_EQ(refused({{"site", 3}}), "/site");
    EXPECT_EQ(refused({{"name", ""}}), "/name");
    EXPECT_EQ(refused({{"rig", std::string(201, 'x')}}), "/rig");
    EXPECT_EQ(refused({{"name", "a\nb"}}), "/name");
    EXPECT_EQ(refused({{"tags", {"a", 1}}}), "/tags/1");
    EXPECT_EQ(refused({{"tags", std::vector<std::string>(65, "a")}}), "/tags");
    EXPECT_EQ(refused({{"notes", std::string(10'001, 'x')}}), "/notes");
    EXPECT_EQ(refused({{"position", {{"latitude_deg", 91}, {"longitude_deg", 0}}}}),
              "/position/latitude_deg");
    EXPECT_EQ(refused({{"position", {{"latitude_deg", 1}}}}), "/position");
    EXPECT_EQ(refused({{"archive_sha256", std::string(64, 'b')}}), "/archive_sha256");
    EXPECT_EQ(get(dive).json(), before);
}

TEST_F(DiveEditTest, ADeletedDiveIsNotEdited) {
    server.request("DELETE", dive, writer, {{"If-Match", "*"}});
    EXPECT_EQ(edit({{"site", "Reef 3"}}).status, 409);
}

TEST_F(DiveEditTest, ASharingLinkShowsNoNotesAndNoPosition) {
    const std::string job = server.make_job("reef", "report.html", "<p>");
    const std::string of_job =
        "/api/v1/dives/" + get("/api/v1/jobs/" + job).json()["dive_id"].get<std::string>();
    const json patch = {{"site", "Reef 3"},
                        {"notes", "for us"},
                        {"position", {{"latitude_deg", 1.5}, {"longitude_deg", 2.5}}}};
    server.request("PATCH", of_job, writer, {{"Content-Type", "application/json"}}, patch.dump());
    const auto share =
        server.post_json("/api/v1/jobs/" + job + "/shares", server.admin(), json::object());
    const auto shown = server.request("GET", of_job, share.json()["secret"]);
    EXPECT_EQ(shown.json()["site"], "Reef 3");
    EXPECT_EQ(shown.body.find("for us"), std::string::npos);
    EXPECT_EQ(shown.json()["position"], nullptr);
    EXPECT_EQ(shown.json()["recorded"], json::object());
}

TEST_F(DiveEditTest, WhoWatchesIsTold) {
    edit({{"site", "Reef 3"}});
    const auto events = storage::EventStore(server.catalog()).since(0, "reef", 100);
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(events.back().type, "dive.edited");
    EXPECT_EQ(events.back().data["site"], "Reef 3");
}

TEST_F(DiveEditTest, MetricsAreListedWithUnitAndDirection) {
    std::map<std::string, json> metrics;
    const auto answer = get("/api/v1/metrics/names").json();
    for (const json& item : answer["items"]) metrics[item["name"]] = item;
    const auto drift = std::find_if(metrics.begin(), metrics.end(), [](const auto& metric) {
        return metric.first.ends_with("drift_percent");
    });
    ASSERT_NE(drift, metrics.end());
    EXPECT_EQ(drift->second["unit"], "%");
    EXPECT_EQ(drift->second["better"], "lower");
    EXPECT_EQ(get("/api/v1/metrics?metric=" + drift->first).status, 200);
}

}  // namespace
}  // namespace divemesh
