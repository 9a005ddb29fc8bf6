#include "sensor/agent.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <thread>

#include "schemas/sensor_status.hpp"
#include "sensor/device_state.hpp"
#include "sensor/status_maker.hpp"
#include "tests/sensor/growing_dive.hpp"
#include "tests/sensor/stream_server.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using namespace std::chrono_literals;

class AgentTest : public testing::Test {
protected:
    AgentTest() {
        settings_.account = {api::client::parse_server_url(server_.url()), "t"};
        settings_.sensor_id = "rig-1";
        settings_.state_folder = folder_ / "state";
        settings_.status_period_s = 0.1;
        settings_.preview_period_s = 0.2;
        settings_.battery_file = folder_ / "battery";
        std::ofstream(folder_ / "battery") << "42\n";
    }
    void run_until(Agent& agent, const std::function<bool()>& done) {
        const auto until = Clock::now() + 10s;
        while (!done() && Clock::now() < until) {
            agent.step(Clock::now());
            dive_.add_frame();
            std::this_thread::sleep_for(20ms);
        }
        EXPECT_TRUE(done());
    }
    std::optional<Heard> newest(const std::string& kind) const {
        std::optional<Heard> newest;
        for (const Heard& heard : server_.heard())
            if (heard.kind == kind && !heard.is_historical) newest = heard;
        return newest;
    }

    TemporaryFolder folder_;
    StreamServer server_;
    GrowingDive dive_{folder_ / "dives" / "wreck"};
    AgentSettings settings_;
};

TEST_F(AgentTest, SendsHelloStatusAndPreview) {
    Agent agent(settings_, watch_folder(folder_ / "dives", {}));
    run_until(agent, [&] {
        const auto status = newest("status");
        return status && status->body.contains("pictures") && newest("preview");
    });
    EXPECT_EQ(server_.heard().front().kind, "hello");
    EXPECT_EQ(newest("hello")->body["capabilities"], nlohmann::json::array({"preview"}));
    const nlohmann::json status = newest("status")->body;
    EXPECT_NO_THROW(check_status(status, ""));
    EXPECT_EQ(status["recording"], true);
    EXPECT_EQ(status["dive"], "wreck");
    EXPECT_EQ(status["battery"], 0.42);
    EXPECT_FALSE(status.contains("depth_m"));  // no sensor measures it
    EXPECT_FALSE(status.contains("leak"));
    EXPECT_EQ(newest("preview")->body["camera"], "cam0");
    EXPECT_EQ(newest("preview")->body["width"], 160);
}

TEST_F(AgentTest, MakesAPreviewThatIsAskedFor) {
    settings_.preview_period_s = 0.0;
    Agent agent(settings_, watch_folder(folder_ / "dives", {}));
    run_until(agent, [&] { return newest("status").has_value(); });
    server_.send({{"command",
                   {{"id", "c1"},
                    {"name", "preview"},
                    {"arguments", {{"camera", "pair"}, {"max_bytes", 3000}}},
                    {"expires_at_ms", 1'700'000'060'000}}}});
    run_until(agent, [&] { return newest("outcome").has_value(); });
    EXPECT_EQ(newest("outcome")->body,
              nlohmann::json::parse(R"({"command": "c1", "state": "done"})"));
    run_until(agent, [&] { return newest("preview").has_value(); });
    EXPECT_EQ(newest("preview")->body["camera"], "pair");
    EXPECT_LE(newest("preview")->num_bytes, 3400u);
}

TEST_F(AgentTest, SendsStoredMessagesAfterARestart) {
    server_.refuse_with(503);
    std::size_t num_waiting = 0;
    {
        Agent agent(settings_, watch_folder(folder_ / "dives", {}));
        run_until(agent, [&] { return agent.ring().num_waiting() > 5; });
        num_waiting = agent.ring().num_waiting();
    }
    server_.refuse_with(0);
    Agent agent(settings_, watch_folder(folder_ / "dives", {}));
    run_until(agent, [&] {
        std::size_t num_historical = 0;
        for (const Heard& heard : server_.heard()) num_historical += heard.is_historical ? 1 : 0;
        return num_historical >= num_waiting;
    });
    EXPECT_FALSE(server_.heard().front().is_historical);
}

TEST_F(AgentTest, ReportsAnUnusableStateFolder) {
    std::ofstream(folder_ / "state") << "no folder";
    Agent agent(settings_, watch_folder(folder_ / "nothing", {}));
    run_until(agent, [&] {
        const auto status = newest("status");
        return status && status->body["errors"].size() == 2;
    });
}

TEST(StatusTest, IsValidForAnyParts) {
    StatusParts parts;
    parts.recording.dive = std::string(60, 'x') + "\xC3\xA4\xC3\xA4\xC3\xA4 \xFF\n";
    for (int i = 0; i < 50; ++i) parts.errors.push_back(std::string(300, '\xFF'));
    parts.recording.counts.orientation = {1.0, 0.0, 0.0, 0.0};
    parts.back_in_s = 60.0;
    EXPECT_NO_THROW(check_status(make_status(parts), ""));
    EXPECT_NO_THROW(make_status(parts).dump());
}

TEST(DeviceStateTest, ReadsBatteryAndLink) {
    const TemporaryFolder folder;
    std::ofstream(folder / "battery") << "87\n";
    EXPECT_EQ(battery_level(folder / "battery"), 0.87);
    std::ofstream(folder / "rubbish") << "full\n";
    EXPECT_EQ(battery_level(folder / "rubbish"), std::nullopt);
    EXPECT_EQ(battery_level(folder / "nothing"), std::nullopt);
    std::ofstream(folder / "wireless")
        << "Inter-| sta-|\n face | tus |\n wlan0: 0000   54.  -56.  -256        0\n";
    EXPECT_EQ(link_rssi_dbm(folder / "wireless"), -56.0);
    EXPECT_EQ(link_rssi_dbm(folder / "nothing"), std::nullopt);
}

TEST(BootTest, HasANameOfItsOwn) {
    EXPECT_NE(new_boot_id(), new_boot_id());
    EXPECT_EQ(new_boot_id().size(), 16u);
}

}  // namespace
}  // namespace divemesh::sensor
