#include <map>
#include <soci/soci.h>
#include <thread>

#include "schemas/event.hpp"
#include "schemas/wall_clock.hpp"
#include "storage/event_store.hpp"
#include "tests/server/sensor_fixture.hpp"

namespace divemesh {
namespace {

using nlohmann::json;
using namespace std::chrono_literals;

class SensorCommandTest : public SensorFixture {
protected:
    RawResponse ask(const json& command, const std::string& token = "") {
        return server_.post_json(
            "/api/v1/sensors/aqua/commands", token.empty() ? operator_ : token, command);
    }
    // Says hello, and what it can do.
    static void greet(WebSocketClient& sensor) {
        sensor.next_json();
        sensor.say(hello(0, {"preview", "start_recording"}));
        EXPECT_EQ(sensor.next_json()["answer"]["acknowledged"], 0);
    }
    static json outcome(int sequence, const std::string& command, const std::string& state) {
        return {{"boot_id", "boot-1"},
                {"messages",
                 {{{"seq", sequence},
                   {"uptime_ms", 1000 * sequence},
                   {"outcome", {{"command", command}, {"state", state}, {"detail", "as told"}}}}}}};
    }
    json command(const std::string& id) { return get("/api/v1/sensors/aqua/commands/" + id); }
    std::vector<std::string> sent_states() {
        std::vector<std::string> states;
        for (const Event& event : storage::EventStore(server_.catalog()).since(0, "", 1000))
            if (event.type == "sensor.command") states.push_back(event.data.at("state"));
        return states;
    }

    const std::string operator_ = server_.make_token("default", {"sensor:command", "dives:read"});
};

TEST_F(SensorCommandTest, IsHandedOverAtOnceAndItsOutcomeIsTold) {
    WebSocketClient sensor = stream();
    greet(sensor);
    const RawResponse made = ask({{"name", "preview"}, {"arguments", {{"max_bytes", 9000}}}});
    ASSERT_EQ(made.status, 201) << made.body;
    const json handed = sensor.next_json()["command"];
    EXPECT_EQ(handed["id"], made.json()["id"]);
    EXPECT_EQ(handed["name"], "preview");
    EXPECT_EQ(handed["arguments"], (json{{"max_bytes", 9000}}));
    EXPECT_EQ(handed["expires_at_ms"], made.json()["expires_at_ms"]);
    EXPECT_EQ(command(made.json()["id"])["state"], "sent");
    sensor.say(outcome(1, made.json()["id"], "done"));
    sensor.next_json();
    const json done = command(made.json()["id"]);
    EXPECT_EQ(done["state"], "done");
    EXPECT_EQ(done["detail"], "as told");
    EXPECT_EQ(sent_states(), (std::vector<std::string>{"pending", "sent", "done"}));
    EXPECT_EQ(get("/api/v1/sensors/aqua/commands")["items"].size(), 1U);
}

TEST_F(SensorCommandTest, NeedsItsScopeAndTheCapability) {
    EXPECT_EQ(ask({{"name", "preview"}}).status, 404) << "never heard of";
    WebSocketClient sensor = stream();
    greet(sensor);
    EXPECT_EQ(ask({{"name", "set_clock"}, {"arguments", {{"time_ms", 1}}}}).status, 409);
    EXPECT_EQ(ask({{"name", "preview"}}, server_.make_token("default", {"dives:write"})).status,
              403);
    EXPECT_EQ(ask({{"name", "preview"}}, token_).status, 403);
    EXPECT_EQ(ask({{"name", "preview"}}, server_.make_token("north", {"sensor:command"})).status,
              404);
    for (const json& wrong : {json{{"name", "explode"}},
                              json{{"name", "preview"}, {"arguments", {{"max_bytes", 1}}}},
                              json{{"name", "preview"}, {"arguments", {{"zoom", 2}}}},
                              json{{"name", "preview"}, {"arguments", 3}},
                              json{{"name", "preview"}, {"expires_in_ms", 10}},
                              json{{"name", "set_clock"}, {"arguments", {{"time_ms", "noon"}}}},
                              json::object()})
        EXPECT_EQ(ask(wrong).status, 400) << wrong;
    for (int i = 0; i < 20; ++i) EXPECT_EQ(ask({{"name", "preview"}}).status, 201);
    EXPECT_EQ(ask({{"name", "preview"}}).status, 429);
}

// Asked for under water, by a clock that is years behind, and without one.
TEST_F(SensorCommandTest, SetsTheClockToWhatItIsWhenHandedOver) {
    {
        WebSocketClient sensor = stream();
        sensor.next_json();
        sensor.say(hello(0, {"set_clock"}));
        sensor.next_json();
    }
    const json behind = ask({{"name", "set_clock"}, {"arguments", {{"time_ms", 1'000}}}}).json();
    const json plain = ask({{"name", "set_clock"}}).json();
    std::this_thread::sleep_for(50ms);
    WebSocketClient sensor = stream();
    const std::int64_t before = sensor.next_json()["welcome"]["time_ms"];
    sensor.say(hello(1, {"set_clock"}));
    std::map<std::string, std::int64_t> told;
    while (told.size() < 2) {
        const json frame = sensor.next_json();
        if (frame.contains("command"))
            told[frame["command"]["id"]] = frame["command"]["arguments"]["time_ms"];
    }
    const std::int64_t after = wall_time_ms();
    const std::int64_t created = behind["created_at_ms"];
    EXPECT_GE(told[behind["id"]] - 1'000, before - created);
    EXPECT_LE(told[behind["id"]] - 1'000, after - created);
    EXPECT_GE(told[plain["id"]], before);
    EXPECT_LE(told[plain["id"]], after);
}

// Under water: handed over on the way up in time, never after.
TEST_F(SensorCommandTest, IsNeverHandedOverLate) {
    {
        WebSocketClient sensor = stream();
        greet(sensor);
    }
    const std::string late = ask({{"name", "preview"}, {"expires_in_ms", 1000}}).json()["id"];
    const std::string in_time = ask({{"name", "start_recording"}}).json()["id"];
    std::this_thread::sleep_for(1100ms);
    WebSocketClient sensor = stream();
    sensor.next_json();
    sensor.say(report(1, json::object()));
    sensor.next_json();
    EXPECT_EQ(sensor.next_json()["command"]["id"], in_time);
    for (int i = 0; i < 100 && command(late)["state"] == "pending"; ++i)
        std::this_thread::sleep_for(50ms);
    EXPECT_EQ(command(late)["state"], "expired");
}

TEST_F(SensorCommandTest, ComesAgainUntilItIsAnswered) {
    std::string id;
    {
        WebSocketClient sensor = stream();
        greet(sensor);
        id = ask({{"name", "preview"}}).json()["id"];
        EXPECT_EQ(sensor.next_json()["command"]["id"], id);
    }
    WebSocketClient sensor = stream();
    sensor.next_json();
    sensor.say(report(1, json::object()));
    sensor.next_json();
    EXPECT_EQ(sensor.next_json()["command"]["id"], id);
    sensor.say(outcome(2, id, "failed"));
    sensor.next_json();
    WebSocketClient third = stream();
    third.next_json();
    third.say(report(3, json::object()));
    third.next_json();
    const std::string next = ask({{"name", "preview"}}).json()["id"];
    EXPECT_EQ(third.next_json()["command"]["id"], next) << "what was answered comes no more";
}

TEST_F(SensorCommandTest, ASensorAnswersForItsOwnAlone) {
    WebSocketClient sensor = stream();
    greet(sensor);
    const std::string id = ask({{"name", "preview"}}).json()["id"];
    EXPECT_EQ(push(sensor_token("rig"), outcome(0, id, "done"), "rig").status, 200);
    EXPECT_EQ(command(id)["state"], "sent");
    EXPECT_EQ(push(token_, outcome(1, id, "glad")).status, 400);
}

}  // namespace
}  // namespace divemesh
