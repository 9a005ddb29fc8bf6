#include "sensor/link/link.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "tests/sensor/stream_server.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

Message message(MessageKind kind, const std::string& body, std::size_t jpeg_bytes = 0) {
    Message message;
    message.kind = kind;
    message.body = body;
    message.jpeg.assign(jpeg_bytes, 'j');
    return message;
}

Message hello() { return message(MessageKind::Hello, R"({"firmware":"1"})"); }
Message status() { return message(MessageKind::Status, R"({"recording":true})"); }
Message preview(std::size_t num_bytes) {
    return message(MessageKind::Preview, R"({"camera":"cam0"})", num_bytes);
}

std::string name_of(const Heard& heard) {
    std::string name = heard.boot_id;
    name.append("/").append(std::to_string(heard.sequence)).append(" ").append(heard.kind);
    return heard.is_historical ? name.append(" then") : name;
}

using Names = std::vector<std::string>;

Names names_of(const std::vector<Heard>& heard) {
    Names names;
    for (const Heard& one : heard) names.push_back(name_of(one));
    return names;
}

class LinkTest : public testing::Test {
protected:
    void connect(LinkSettings settings = {}) {
        settings.on_event = [this](const std::string& what) {
            const std::lock_guard lock(mutex_);
            events_.push_back(what);
        };
        link_ = std::make_unique<Link>(
            api::client::Account{api::client::parse_server_url(server_.url()), "t"},
            "rig-1",
            ring_,
            settings);
    }
    bool wait_until_empty() {
        const auto until = Clock::now() + 10s;
        while (ring_.num_waiting() > 0 && Clock::now() < until) std::this_thread::sleep_for(5ms);
        return ring_.num_waiting() == 0;
    }
    std::string last_event() {
        const std::lock_guard lock(mutex_);
        return events_.empty() ? "" : events_.back();
    }

    TemporaryFolder folder_;
    MessageRing ring_{folder_ / "ring", MessageRing::kMinBytes, "now"};
    StreamServer server_;
    std::mutex mutex_;
    std::vector<std::string> events_;
    std::unique_ptr<Link> link_;
};

TEST_F(LinkTest, SendsHelloAndTheNewestMessagesBeforeOlderOnes) {
    ring_.append(hello());
    ring_.append(status());
    ring_.append(preview(1000));
    ring_.append(status());
    ring_.append(status());
    ring_.append(preview(1000));
    connect();
    ASSERT_TRUE(wait_until_empty());
    EXPECT_EQ(names_of(server_.heard()),
              (Names{"now/0 hello",
                     "now/4 status",
                     "now/5 preview",
                     "now/1 status then",
                     "now/3 status then",
                     "now/2 preview then"}));
}

TEST_F(LinkTest, SaysWhatAnEarlierBootSaidAsHistory) {
    {
        MessageRing before(folder_ / "two", MessageRing::kMinBytes, "before");
        before.append(status());
        before.append(preview(100));
    }
    MessageRing ring(folder_ / "two", MessageRing::kMinBytes, "now");
    ring.append(status());
    const Link link({api::client::parse_server_url(server_.url()), "t"}, "rig-1", ring, {});
    ASSERT_TRUE(server_.wait_for(3));
    EXPECT_EQ(names_of(server_.heard()),
              (Names{"now/0 status", "before/0 status then", "before/1 preview then"}));
}

TEST_F(LinkTest, SendsAgainWhatWasNotAnsweredAndNothingElse) {
    ring_.append(hello());
    ring_.append(status());
    connect();
    ASSERT_TRUE(wait_until_empty());
    server_.answer(false);
    ring_.append(status());
    ring_.append(status());
    ASSERT_TRUE(server_.wait_for(4));
    server_.answer(true);
    const auto cut_at = Clock::now();
    server_.cut();
    ASSERT_TRUE(wait_until_empty());
    EXPECT_LT(Clock::now() - cut_at, 2s);
    Names again;
    for (const Heard& heard : server_.heard())
        if (heard.connection == 1) again.push_back(name_of(heard));
    EXPECT_EQ(again, (Names{"now/3 status", "now/2 status then"}));
}

TEST_F(LinkTest, MarksOlderStatusesAsHistorical) {
    ring_.append(status());
    ring_.append(status());
    server_.answer(true);
    connect();
    ASSERT_TRUE(wait_until_empty());
    server_.cut();
    ring_.append(preview(10));
    ASSERT_TRUE(wait_until_empty());
    int num_statuses = 0;
    for (const Heard& heard : server_.heard()) {
        if (heard.kind != "status") continue;
        ++num_statuses;
        EXPECT_EQ(heard.is_historical, heard.sequence == 0);
    }
    EXPECT_EQ(num_statuses, 2);
}

TEST_F(LinkTest, KeepsNoMoreThanTheProtocolAllowsUnanswered) {
    server_.answer(false);
    for (int i = 0; i < 200; ++i) ring_.append(message(MessageKind::Status, "{}"));
    for (int i = 0; i < 5; ++i) ring_.append(preview(60'000));
    connect({.timeout = 60s});
    std::this_thread::sleep_for(700ms);
    std::size_t num_bytes = 0;
    const auto heard = server_.heard();
    for (const Heard& one : heard) num_bytes += one.num_bytes;
    EXPECT_LE(heard.size(), 64u);
    EXPECT_GE(heard.size(), 1u);
    EXPECT_LE(num_bytes, 8192u);  // no rate is known: little is risked
}

TEST_F(LinkTest, KeepsToTheLimitOfItsRate) {
    for (int i = 0; i < 20; ++i) ring_.append(preview(10'000));
    const auto begin = Clock::now();
    connect({.max_bytes_per_s = 100'000.0});
    ASSERT_TRUE(wait_until_empty());
    const std::chrono::duration<double> took = Clock::now() - begin;
    EXPECT_GT(took.count(), 1.7);
}

TEST_F(LinkTest, WaitsForAServerThatOnlyWritesSlowly) {
    server_.answer(false);  // but its pongs come
    ring_.append(status());
    connect({.timeout = 500ms});
    ASSERT_TRUE(server_.wait_for(1));
    std::this_thread::sleep_for(1000ms);
    EXPECT_EQ(server_.num_connections(), 1);
}

TEST_F(LinkTest, GivesUpALinkOverWhichNothingComesBack) {
    ring_.append(hello());
    connect({.timeout = 500ms});
    ASSERT_TRUE(wait_until_empty());
    server_.stall(true);
    ring_.append(status());
    const auto begin = Clock::now();
    ASSERT_TRUE(server_.wait_for_connections(2));
    EXPECT_LT(Clock::now() - begin, 2s);
    server_.stall(false);
    EXPECT_TRUE(wait_until_empty());
}

TEST_F(LinkTest, KeepsAwayWhenAnotherDeviceSpeaksForIt) {
    ring_.append(hello());
    connect({.refused_pause = 1500ms});
    ASSERT_TRUE(wait_until_empty());
    server_.close_with(4409);
    std::this_thread::sleep_for(1000ms);
    EXPECT_EQ(server_.num_connections(), 1);
    EXPECT_NE(last_event().find("another device"), std::string::npos) << last_event();
    EXPECT_TRUE(server_.wait_for_connections(2, 3s));
}

TEST_F(LinkTest, KeepsAwayWhenItsTokenIsRefused) {
    server_.refuse_with(403);
    connect({.refused_pause = 1500ms});
    ASSERT_TRUE(server_.wait_for_connections(1));
    std::this_thread::sleep_for(1000ms);
    EXPECT_EQ(server_.num_connections(), 1);
    EXPECT_NE(last_event().find("sensor:push"), std::string::npos) << last_event();
    server_.refuse_with(0);
    ring_.append(hello());
    EXPECT_TRUE(server_.wait_for(1, 3s));
}

TEST_F(LinkTest, ReportsRefusedMessagesAsLost) {
    server_.refuse_kind("preview");
    ring_.append(preview(10));
    ring_.append(status());
    connect();
    ASSERT_TRUE(server_.wait_for(3));
    ASSERT_TRUE(wait_until_empty());
    const auto heard = server_.heard();
    EXPECT_EQ(heard.back().kind, "lost");
    EXPECT_EQ(heard.back().body, nlohmann::json::parse("[[0,0]]"));
    const auto until = Clock::now() + 5s;
    while (ring_.lost() && Clock::now() < until) std::this_thread::sleep_for(5ms);
    EXPECT_FALSE(ring_.lost());
}

TEST_F(LinkTest, HandsOverCommandsWithTheServersTime) {
    connect();
    ASSERT_TRUE(server_.wait_for_connections(1));
    server_.send({{"command", {{"id", "c1"}, {"name", "preview"}, {"expires_at_ms", 1}}}});
    server_.send({{"command", "rubbish"}});
    server_.send({{"command", {{"id", 7}}}});
    std::vector<Command> commands;
    const auto until = Clock::now() + 5s;
    while (commands.empty() && Clock::now() < until) {
        commands = link_->take_commands();
        std::this_thread::sleep_for(5ms);
    }
    ASSERT_EQ(commands.size(), 1u);
    EXPECT_EQ(commands[0].id, "c1");
    EXPECT_EQ(commands[0].server_time.time_ms, 1'700'000'000'000);
}

TEST_F(LinkTest, WaitsForAServerThatIsNotThere) {
    const auto begin = Clock::now();
    {
        const Link link({api::client::parse_server_url("http://127.0.0.1:1"), "t"}, "x", ring_, {});
        std::this_thread::sleep_for(300ms);
        EXPECT_FALSE(link.state().is_connected);
        EXPECT_NE(link.state().trouble, "");
    }
    EXPECT_LT(Clock::now() - begin, 2s);
}

}  // namespace
}  // namespace divemesh::sensor
