#include <soci/soci.h>
#include <thread>

#include "schemas/content_hash.hpp"
#include "tests/server/sensor_fixture.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

class SensorStreamTest : public SensorFixture {};

TEST_F(SensorStreamTest, WhatIsSentIsAnsweredOnceItIsDurable) {
    WebSocketClient sensor = stream();
    EXPECT_GT(sensor.next_json()["welcome"]["time_ms"], std::int64_t{1'700'000'000'000});
    sensor.say(hello(0, json::array()));
    json answer = sensor.next_json();
    EXPECT_EQ(answer["answer"]["acknowledged"], 0);
    EXPECT_EQ(answer["committed"], json::parse("[[0,0]]"));
    sensor.say(report(3, {{"battery", 0.8}}));
    answer = sensor.next_json();
    EXPECT_EQ(answer["committed"], json::parse("[[3,3]]"));
    EXPECT_EQ(answer["answer"]["gaps"], json::parse(R"([{"first": 1, "last": 2}])"));
    EXPECT_EQ(get("/api/v1/sensors/aqua")["status"]["battery"], 0.8);
    // What comes by either way is the same message.
    EXPECT_EQ(push(token_, report(3, {{"battery", 0.1}})).json()["num_repeated"], 1);
}

TEST_F(SensorStreamTest, ManyAtOnceAreWrittenTogetherAndAllAnswered) {
    WebSocketClient sensor = stream();
    sensor.next_json();
    constexpr int kNumMessages = 1000;
    for (int i = 0; i < kNumMessages; ++i) sensor.say(report(i, {{"battery", 0.5}}));
    int num_answers = 0;
    for (std::int64_t acknowledged = -1; acknowledged < kNumMessages - 1; ++num_answers)
        acknowledged = sensor.next_json()["answer"]["acknowledged"].get<std::int64_t>();
    EXPECT_LT(num_answers, kNumMessages / 2);
    EXPECT_EQ(get("/api/v1/sensors/aqua/history?fields=battery&steps=1")["num_statuses"],
              json::array({kNumMessages}));
}

// Sends three seconds of a device with a thousand messages a second at once.
TEST_F(SensorStreamTest, AFloodIsTakenAndKeepsNoOtherSensorWaiting) {
    constexpr int kMany = 3'000;
    const std::string other = sensor_token("other");
    WebSocketClient sensor = stream();
    sensor.next_json();
    std::thread flood([&] {
        for (int i = 0; i < kMany; ++i) sensor.say(report(i, {{"num_frames", i}}));
    });
    std::vector<int> statuses;
    for (int i = 0; i < 10; ++i)
        statuses.push_back(push(other, report(i, {{"battery", 0.5}}), "other").status);
    flood.join();
    std::int64_t acknowledged = -1;
    while (acknowledged < kMany - 1)
        acknowledged = sensor.next_json().at("answer").at("acknowledged");
    EXPECT_EQ(statuses, std::vector<int>(10, 200));
    EXPECT_EQ(get("/api/v1/sensors/aqua")["status"]["num_frames"], kMany - 1);
}

TEST_F(SensorStreamTest, APreviewIsShownWithItsAge) {
    WebSocketClient sensor = stream();
    sensor.next_json();
    const std::string image = jpeg();
    sensor.say_bytes(preview_frame(
        preview_header(0, {{"camera", "cam0"}, {"exposure_ms", 4}, {"pictures", {{"dark", 0.9}}}}),
        image));
    EXPECT_EQ(sensor.next_json()["committed"], json::parse("[[0,0]]"));

    const json shown = get("/api/v1/sensors/aqua");
    const json& preview = shown["previews"]["cam0"];
    EXPECT_EQ(preview["width"], 64);
    EXPECT_EQ(preview["height"], 48);
    EXPECT_EQ(preview["sha256"], sha256_hex(image));
    EXPECT_EQ(preview["about"]["exposure_ms"], 4);
    EXPECT_EQ(shown["summary"], "stop") << "nine of ten images are dark";
    const RawResponse newest =
        server_.request("GET", "/api/v1/sensors/aqua/preview.jpg?camera=cam0", server_.admin());
    EXPECT_EQ(newest.body, image);
    EXPECT_EQ(newest.header("content-type"), "image/jpeg");
    EXPECT_LT(std::stoi(newest.header("age")), 20);
    EXPECT_NE(newest.header("last-modified"), "");
    const RawResponse same = server_.request("GET",
                                             "/api/v1/sensors/aqua/preview.jpg",
                                             server_.admin(),
                                             {{"If-None-Match", newest.header("etag")}});
    EXPECT_EQ(same.status, 304);
    const json all = get("/api/v1/sensors/aqua/previews")["items"];
    ASSERT_EQ(all.size(), 1U);
    const std::string address =
        "/api/v1/sensors/aqua/previews/" + std::to_string(all[0]["id"].get<std::int64_t>());
    EXPECT_EQ(server_.request("GET", address, server_.admin()).body, image);
    for (const std::string none :
         {"preview.jpg?camera=cam1", "previews/999", "previews/x", "previews/-1"})
        EXPECT_EQ(server_.request("GET", "/api/v1/sensors/aqua/" + none, server_.admin()).status,
                  404)
            << none;
}

TEST_F(SensorStreamTest, TheNewestImagesAreKept) {
    WebSocketClient sensor = stream();
    sensor.next_json();
    const std::string image = jpeg(16, 16);
    for (int i = 0; i < 205; ++i)
        sensor.say_bytes(preview_frame(preview_header(i, {{"camera", "cam0"}}), image));
    for (std::int64_t acknowledged = -1; acknowledged < 204;)
        acknowledged = sensor.next_json()["answer"]["acknowledged"].get<std::int64_t>();
    const json all = get("/api/v1/sensors/aqua/previews")["items"];
    ASSERT_EQ(all.size(), 200U);
    EXPECT_GT(all[0]["time_ms"], all[199]["time_ms"]);
    EXPECT_EQ(get("/api/v1/sensors/aqua/previews?limit=5")["items"].size(), 5U);
}

// The stream goes on after each of them.
TEST_F(SensorStreamTest, WhatIsNoFrameIsRefusedByItsNumber) {
    WebSocketClient sensor = stream();
    sensor.next_json();
    const std::string whole = jpeg();
    const json header = preview_header(7, {{"camera", "cam0"}});
    std::string giant = whole;  // says that it is 20000 x 20000
    const std::size_t frame = giant.find("\xFF\xC0");
    ASSERT_NE(frame, std::string::npos);
    giant.replace(frame + 5, 4, "\x4E\x20\x4E\x20");
    const json camera_less = preview_header(7, json::object());
    for (const std::string& bytes :
         {preview_frame(header, "not an image"),
          preview_frame(header, giant),
          preview_frame(header, whole.substr(0, whole.size() / 2)),
          preview_frame(header, ""),
          preview_frame(header, whole + std::string(300'000, 'x') + "\xFF\xD9"),
          preview_frame(camera_less, whole),
          preview_frame(report(7, json::object()), whole)}) {
        sensor.say_bytes(bytes);
        const json refused = sensor.next_json();
        EXPECT_EQ(refused["messages"], json::array({7})) << refused;
        EXPECT_EQ(refused["refused"]["status"], 400) << refused;
    }
    for (const std::string& bytes :
         {std::string(), std::string("\0\0", 2), whole, std::string("\xFF\xFF\xFF\xFFx")}) {
        sensor.say_bytes(bytes);
        EXPECT_EQ(sensor.next_json()["messages"], json::array());
    }
    for (const std::string text :
         {"", "[", "null", "{}", "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[["}) {
        sensor.say_text(text);
        EXPECT_TRUE(sensor.next_json().contains("refused")) << text;
    }
    sensor.say(report(7, {{"battery", "full"}}));
    const json refused = sensor.next_json();
    EXPECT_EQ(refused["refused"]["errors"][0]["pointer"], "/messages/0/status/battery");
    EXPECT_EQ(refused["boot_id"], "boot-1");
    sensor.say(report(7, {{"battery", 1}}));
    EXPECT_EQ(sensor.next_json()["committed"], json::parse("[[7,7]]"));
}

TEST_F(SensorStreamTest, AFrameThatIsTooLongEndsTheStream) {
    WebSocketClient sensor = stream();
    sensor.next_json();
    sensor.say_text(std::string((1U << 20) + 1, ' '));
    EXPECT_EQ(sensor.close_code(), 1009U);
}

TEST_F(SensorStreamTest, ATokenSpeaksForItsSensorAlone) {
    const std::string other = sensor_token("other");
    for (const std::string& token :
         {other, server_.make_token("default", {"dives:read"}), std::string("dm_wrong")})
        EXPECT_THROW(WebSocketClient(server_.port(), token, "/api/v1/sensors/aqua/stream"),
                     boost::system::system_error);
    EXPECT_EQ(server_.request("GET", "/api/v1/sensors/aqua/stream", token_).status, 426);
}

TEST_F(SensorStreamTest, TheNewestStreamTakesTheSensorsPlace) {
    WebSocketClient first = stream();
    first.next_json();
    WebSocketClient second = stream();
    second.next_json();
    EXPECT_EQ(first.close_code(), 4409U);
    second.say(report(0, json::object()));
    EXPECT_EQ(second.next_json()["answer"]["acknowledged"], 0);
}

TEST_F(SensorStreamTest, ATokenThatEndsEndsTheStream) {
    const auto made =
        server_.post_json("/api/v1/tokens",
                          server_.admin(),
                          {{"name", "rig"}, {"scopes", {"sensor:push"}}, {"sensor", "rig"}});
    ASSERT_EQ(made.status, 201) << made.body;
    WebSocketClient sensor(server_.port(), made.json()["secret"], "/api/v1/sensors/rig/stream");
    sensor.next_json();
    server_.request(
        "DELETE", "/api/v1/tokens/" + made.json()["id"].get<std::string>(), server_.admin());
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
    sensor.say(report(0, json::object()));
    EXPECT_EQ(sensor.close_code(), 1008U);
}

TEST_F(SensorStreamTest, ASensorOfAnotherProjectIsClosedWithTheReason) {
    push(token_, report(0, json::object()));
    WebSocketClient thief(
        server_.port(), sensor_token("aqua", "north"), "/api/v1/sensors/aqua/stream");
    thief.next_json();
    thief.say(report(1, json::object()));
    EXPECT_EQ(thief.close_code(), 1008U);
}

TEST_F(SensorStreamTest, TheServerSaysGoodbyeWhenItStops) {
    WebSocketClient sensor = stream();
    sensor.next_json();
    std::thread stopping([this] { server_.stop(); });
    EXPECT_EQ(sensor.close_code(), 1001U);
    stopping.join();
}

}  // namespace
}  // namespace divemesh
