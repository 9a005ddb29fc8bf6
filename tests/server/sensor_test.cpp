#include <atomic>
#include <soci/soci.h>
#include <thread>

#include "schemas/json.hpp"
#include "storage/event_store.hpp"
#include "tests/server/sensor_fixture.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

class SensorTest : public SensorFixture {};

TEST_F(SensorTest, AStatusIsAcknowledgedAndShown) {
    const RawResponse answer = push(token_, report(0, {{"battery", 0.8}, {"depth_m", 0.4}}));
    ASSERT_EQ(answer.status, 200) << answer.body;
    EXPECT_EQ(answer.json()["acknowledged"], 0);
    EXPECT_EQ(answer.json()["num_new"], 1);
    EXPECT_EQ(push(token_, report(0, {{"battery", 0.1}})).json()["num_repeated"], 1);

    const json sensor = get("/api/v1/sensors/aqua");
    EXPECT_EQ(sensor["state"], "online");
    EXPECT_EQ(sensor["summary"], "ok");
    EXPECT_EQ(sensor["status"]["battery"], 0.8);
    EXPECT_FALSE(sensor["stale"].get<bool>());
    EXPECT_EQ(get("/api/v1/sensors")["items"].size(), 1U);
    EXPECT_EQ(get("/api/v1/sensors?fields=id,state")["items"][0],
              (json{{"id", "aqua"}, {"state", "online"}}));
    const json history = get("/api/v1/sensors/aqua/history?fields=battery,leak&steps=10");
    EXPECT_EQ(history["num_statuses"], json::array({1}));
    EXPECT_EQ(history["fields"]["battery"]["largest"], json::array({0.8}));
    EXPECT_EQ(history["fields"]["leak"]["largest"], json::array({nullptr}));
}

TEST_F(SensorTest, ATokenPushesForItsSensorAndDoesNothingElse) {
    EXPECT_EQ(push(token_, report(0, json::object()), "other").status, 404);
    EXPECT_EQ(push(server_.make_token("default", {"dives:write"}), report(0, {})).status, 403);
    EXPECT_EQ(push("", report(0, {})).status, 401);
    EXPECT_EQ(server_.request("GET", "/api/v1/sensors", token_).status, 403);
    EXPECT_EQ(server_.request("GET", "/api/v1/dives", token_).status, 403);
    EXPECT_EQ(server_.request("GET", "/api/v1/sensors/aqua", server_.admin()).status, 404);
}

TEST_F(SensorTest, OfAnotherProjectASensorIsNotThere) {
    push(token_, report(0, json::object()));
    const std::string north = server_.make_token("north", {"dives:read"});
    EXPECT_EQ(server_.request("GET", "/api/v1/sensors", north).json()["items"].size(), 0U);
    EXPECT_EQ(server_.request("GET", "/api/v1/sensors/aqua", north).status, 404);
    EXPECT_EQ(server_.request("GET", "/api/v1/sensors/aqua/history?fields=battery", north).status,
              404);
    EXPECT_EQ(push(sensor_token("aqua", "north"), report(9, json::object())).status, 409);
    EXPECT_EQ(get("/api/v1/sensors/aqua")["acknowledged"], 0);
}

TEST_F(SensorTest, WhatIsNoReportIsRefusedWithItsPlaces) {
    const RawResponse wrong = push(token_, report(0, {{"battery", 7}, {"leak", "yes"}}));
    ASSERT_EQ(wrong.status, 400);
    EXPECT_EQ(wrong.json()["errors"].size(), 2U);
    EXPECT_EQ(wrong.json()["errors"][0]["pointer"], "/messages/0/status/battery");
    EXPECT_EQ(push(token_, {{"messages", json::array()}}).status, 400);
    EXPECT_EQ(push(token_, {{"boot_id", "b"}, {"messages", {{{"seq", 1}}}}}).status, 400);
    const Headers headers = {{"Content-Type", "application/json"}};
    for (const std::string body : {"{\"boot_id\":\"b\",\"messages\":[{\"seq\":0,\"uptime_ms\":0,"
                                   "\"status\":{\"depth_m\":NaN}}]}",
                                   "[",
                                   "",
                                   "null"})
        EXPECT_EQ(
            server_.request("POST", "/api/v1/sensors/aqua/status", token_, headers, body).status,
            400)
            << body;
    EXPECT_EQ(server_.request("GET", "/api/v1/sensors/aqua", server_.admin()).status, 404)
        << "nothing came of all that";
}

TEST_F(SensorTest, AHistoryIsAskedForRightly) {
    push(token_, report(0, {{"battery", 0.8}}));
    for (const std::string query : {"",
                                    "?fields=",
                                    "?fields=more",
                                    "?fields=battery%3B",
                                    "?fields=battery&steps=0",
                                    "?fields=battery&steps=5001",
                                    "?fields=battery&from=9&to=9",
                                    "?fields=battery&from=-1",
                                    "?fields=battery&to=99999999999999999999"})
        EXPECT_EQ(
            server_.request("GET", "/api/v1/sensors/aqua/history" + query, server_.admin()).status,
            400)
            << query;
}

TEST_F(SensorTest, AlarmsAreEvents) {
    push(token_, report(0, {{"leak", true}}));
    std::vector<Event> alarms;
    for (const Event& event : storage::EventStore(server_.catalog()).since(0, "default", 100))
        if (event.type == "sensor.alarm") alarms.push_back(event);
    ASSERT_EQ(alarms.size(), 1U);
    EXPECT_EQ(alarms[0].data["name"], "leak");
    EXPECT_EQ(alarms[0].data["level"], "stop");
    EXPECT_EQ(get("/api/v1/sensors/aqua")["summary"], "stop");
}

// Reports that are under way at once share transactions; each is answered with its own.
TEST_F(SensorTest, ReportsAtOnceAreEachAnsweredAndKept) {
    constexpr int kNumSensors = 12;
    constexpr int kNumReports = 25;
    std::vector<std::string> tokens;
    for (int i = 0; i < kNumSensors; ++i) tokens.push_back(sensor_token("s" + std::to_string(i)));
    std::atomic<int> num_right = 0;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < kNumSensors; ++i)
            threads.emplace_back([&, i] {
                RawClient client(server_.port());
                const std::string path = "/api/v1/sensors/s" + std::to_string(i) + "/status";
                for (int k = 0; k < kNumReports; ++k) {
                    const auto answer = client.request(
                        "POST",
                        path,
                        {{"Authorization", "Bearer " + tokens[static_cast<std::size_t>(i)]},
                         {"Content-Type", "application/json"}},
                        report(k, {{"battery", 0.5}}).dump());
                    num_right += answer.status == 200 && answer.json()["acknowledged"] == k &&
                                 answer.json()["num_new"] == 1;
                }
            });
    }
    EXPECT_EQ(num_right, kNumSensors * kNumReports);
    EXPECT_EQ(get("/api/v1/sensors?limit=200")["items"].size(),
              static_cast<std::size_t>(kNumSensors));
    long long num_rows = 0;
    server_.catalog().read([&](soci::session& session) {
        session << "SELECT COUNT(*) FROM sensor_statuses", soci::into(num_rows);
    });
    EXPECT_EQ(num_rows, kNumSensors * kNumReports);
}

class SensorOnAFullDiskTest : public SensorFixture {
protected:
    static server::ServerConfig full() {
        server::ServerConfig config;
        config.min_free_bytes = std::int64_t{1} << 60;
        return config;
    }
    SensorOnAFullDiskTest() : SensorFixture(full()) {}
};

// On a nearly full disk every status is stored, but only the newest few images.
TEST_F(SensorOnAFullDiskTest, KeepsFewPreviewsAndEveryStatus) {
    const json image = {{"camera", "cam0"}, {"jpeg", base64(jpeg())}};
    for (int i = 0; i < 30; i += 2) {
        ASSERT_EQ(push(token_, report(i, {{"battery", 0.5}, {"depth_m", i}})).status, 200);
        const json preview = {
            {"boot_id", "boot-1"},
            {"messages", {{{"seq", i + 1}, {"uptime_ms", 1000 * i}, {"preview", image}}}}};
        const RawResponse answer = push(token_, preview);
        ASSERT_EQ(answer.status, 200) << answer.body;
    }
    EXPECT_EQ(get("/api/v1/sensors/aqua/previews")["items"].size(), 10U);
    EXPECT_EQ(get("/api/v1/sensors/aqua")["status"]["depth_m"], 28);
}

}  // namespace
}  // namespace divemesh
