#include <gtest/gtest.h>

#include "tests/end_to_end/webhook_receiver.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

class WebhookTest : public testing::Test {
protected:
    void SetUp() override {
        if (!WebhookReceiver::is_installed())
            GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    }

    Service service;
};

// The reference library of Standard Webhooks accepts our signatures.
TEST_F(WebhookTest, MessagesPassTheLibraryOfStandardWebhooks) {
    WebhookReceiver receiver(service, 0, {"upload", "dive"});
    const Outcome upload = service.run({"upload", small_dive().string(), "--no-job"}, 60s);
    ASSERT_EQ(upload.exit_code, 0) << upload.err;
    EXPECT_TRUE(receiver.hears("dive.created", 30s)) << receiver.heard();
    EXPECT_EQ(receiver.events("upload.completed").size(), 1U);
    EXPECT_EQ(receiver.heard().find("bad"), std::string::npos) << receiver.heard();
}

TEST_F(WebhookTest, ASensorsLeakIsDeliveredOnceAndSoIsItsEnd) {
    WebhookReceiver receiver(service, 0, {"sensor"});
    const Outcome made = service.run({"token",
                                      "create",
                                      "--data",
                                      (service / "data").string(),
                                      "--name",
                                      "rig-1",
                                      "--scope",
                                      "sensor:push",
                                      "--sensor",
                                      "rig-1"});
    api::client::RestClient sensor({api::client::parse_server_url(service.address()),
                                    made.out.substr(0, made.out.find('\n'))});
    const auto say = [&](int seq, bool leak) {
        sensor.post("/api/v1/sensors/rig-1/status",
                    {{"boot_id", "boot-1"},
                     {"messages",
                      {{{"seq", seq}, {"uptime_ms", 1000 * seq}, {"status", {{"leak", leak}}}}}}});
    };
    say(0, false);
    say(1, true);
    say(2, true);
    say(3, false);
    const auto alarms = [&] { return receiver.events("sensor.alarm"); };
    ASSERT_TRUE(wait_until(30s, [&] { return alarms().size() >= 2; })) << receiver.heard();
    EXPECT_EQ(alarms().size(), 2U) << receiver.heard();
    EXPECT_EQ(alarms()[0].at("name"), "leak");
    EXPECT_EQ(alarms()[0].at("level"), "stop");
    EXPECT_EQ(alarms()[0].at("raised"), true);
    EXPECT_EQ(alarms()[1].at("raised"), false);
    EXPECT_EQ(receiver.heard().find("bad"), std::string::npos) << receiver.heard();
}

}  // namespace
}  // namespace divemesh
