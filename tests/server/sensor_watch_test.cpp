#include <chrono>
#include <thread>

#include "tests/server/sensor_fixture.hpp"

namespace divemesh {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

class SensorWatchTest : public SensorFixture {
protected:
    WebSocketClient watch(const std::string& sensors) {
        return {server_.port(), server_.admin(), "/api/v1/events?sensors=" + sensors};
    }
    // The next frame about a sensor: events come in between.
    static json next_frame_of(WebSocketClient& watcher) {
        for (;;) {
            json frame = watcher.next_json();
            if (frame["type"] == "sensor.snapshot" || frame["type"] == "sensor.delta") return frame;
        }
    }
    static json without_age(json sensor) {
        sensor.erase("status_age_ms");
        return sensor;
    }
};

TEST_F(SensorWatchTest, ASnapshotAndThenWhatHasChanged) {
    push(token_, report(0, {{"battery", 0.8}, {"depth_m", 0.4}}));
    WebSocketClient watcher = watch("aqua");
    const json snapshot = next_frame_of(watcher);
    ASSERT_EQ(snapshot["type"], "sensor.snapshot");
    EXPECT_EQ(snapshot["data"], without_age(get("/api/v1/sensors/aqua")));

    push(token_, report(1, {{"battery", 0.8}, {"temperature_c", 9.5}}));
    const json delta = next_frame_of(watcher);
    ASSERT_EQ(delta["type"], "sensor.delta");
    EXPECT_EQ(delta["previous"], snapshot["revision"]);
    EXPECT_EQ(delta["patch"]["status"], (json{{"depth_m", nullptr}, {"temperature_c", 9.5}}));
    json patched = snapshot["data"];
    patched.merge_patch(delta["patch"]);
    EXPECT_EQ(patched, without_age(get("/api/v1/sensors/aqua")));
}

// A null in a status would be a removal in a patch.
TEST_F(SensorWatchTest, WhatIsNullIsLeftOut) {
    push(token_, report(0, {{"battery", nullptr}, {"vendor", {{"fan", nullptr}, {"rpm", 3}}}}));
    WebSocketClient watcher = watch("aqua");
    EXPECT_EQ(next_frame_of(watcher)["data"]["status"], (json{{"vendor", {{"rpm", 3}}}}));
}

TEST_F(SensorWatchTest, TwoFramesASecondAtMostAndTheNewestOne) {
    push(token_, report(0, {{"num_frames", 0}}));
    WebSocketClient watcher = watch("aqua");
    json shown = next_frame_of(watcher)["data"];
    const auto begin = Clock::now();
    constexpr int kLast = 40;
    std::thread sensor([this] {
        for (int i = 1; i <= kLast; ++i) {
            push(token_, report(i, {{"num_frames", i}}));
            std::this_thread::sleep_for(20ms);
        }
    });
    int num_frames = 1;
    for (; shown["status"]["num_frames"] != kLast; ++num_frames)
        shown.merge_patch(next_frame_of(watcher)["patch"]);
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    sensor.join();
    EXPECT_LE(num_frames, 2.0 * (seconds + 1.0));
}

TEST_F(SensorWatchTest, WhoWatchesSomeIsToldOfTheseAlone) {
    push(token_, report(0, json::object()));
    push(sensor_token("rig"), report(0, json::object()), "rig");
    WebSocketClient watcher = watch("rig");
    EXPECT_EQ(next_frame_of(watcher)["sensor"], "rig");
    push(token_, report(1, {{"battery", 0.5}}));
    push(sensor_token("rig"), report(1, {{"battery", 0.4}}), "rig");
    EXPECT_EQ(next_frame_of(watcher)["sensor"], "rig");
}

TEST_F(SensorWatchTest, OfAnotherProjectNothingIsTold) {
    push(token_, report(0, json::object()));
    const std::string north = server_.make_token("north", {"dives:read"});
    EXPECT_THROW(WebSocketClient(server_.port(), north, "/api/v1/events?sensors=aqua"),
                 boost::system::system_error);
    EXPECT_THROW(watch("nobody"), boost::system::system_error);
}

// An image is announced; its bytes are fetched.
TEST_F(SensorWatchTest, AnImageIsAnnounced) {
    push(token_, report(0, json::object()));
    WebSocketClient watcher = watch("aqua");
    next_frame_of(watcher);
    WebSocketClient sensor = stream();
    sensor.next_json();
    sensor.say_bytes(preview_frame(preview_header(1, {{"camera", "cam1"}}), jpeg()));
    const json patch = next_frame_of(watcher)["patch"];
    EXPECT_EQ(patch["previews"]["cam1"]["width"], 64);
}

}  // namespace
}  // namespace divemesh
