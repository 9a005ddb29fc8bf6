#include <gtest/gtest.h>

#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <future>
#include <soci/soci.h>

#include "schemas/content_hash.hpp"
#include "schemas/json.hpp"
#include "storage/event_store.hpp"
#include "tests/server/test_server.hpp"
#include "tests/server/web_socket_client.hpp"

namespace divemesh {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using namespace std::chrono_literals;

class EventClient : public WebSocketClient {
public:
    EventClient(int port, const std::string& token, const std::string& query)
        : WebSocketClient(port, token, "/api/v1/events" + query) {}

    Event next() { return next_json().get<Event>(); }
};

RawResponse open_socket(RawClient& client,
                        const std::string& token,
                        const std::string& query = "") {
    const Headers headers = {{"Upgrade", "websocket"},
                             {"Connection", "Upgrade"},
                             {"Sec-WebSocket-Version", "13"},
                             {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="},
                             {"Sec-WebSocket-Extensions", "permessage-deflate"},
                             {"Authorization", "Bearer " + token}};
    client.send(request_head("GET", "/api/v1/events" + query, headers, std::nullopt));
    return client.receive().value_or(RawResponse{});
}

TEST(EventsTest, TellsWhatHappensInOrderAndResumesAfterTheLastSeen) {
    TestServer server;
    server.make_dive("default", sha256_hex("1"));
    EventClient all(server.port(), server.admin(), "?since=0");
    std::vector<Event> seen = {all.next()};
    while (seen.back().type != "dive.created") seen.push_back(all.next());
    for (std::size_t i = 1; i < seen.size(); ++i) EXPECT_GT(seen[i].sequence, seen[i - 1].sequence);
    EventClient resumed(
        server.port(), server.admin(), "?since=" + std::to_string(seen[0].sequence));
    EXPECT_EQ(resumed.next().sequence, seen[1].sequence);
}

// After a restored backup, or after a long time: silence would be taken for nothing new.
TEST(EventsTest, SinceAnUnknownEventIsRefused) {
    TestServer server;
    server.make_dive("default", sha256_hex("1"));
    const auto status_since = [&](std::int64_t sequence) {
        RawClient client(server.port());
        return open_socket(client, server.admin(), "?since=" + std::to_string(sequence)).status;
    };
    const auto newest = storage::EventStore(server.catalog()).newest_sequence();
    EXPECT_EQ(status_since(newest), 101);
    EXPECT_EQ(status_since(newest + 1), 410);
    EXPECT_EQ(status_since(1), 101);
    server.catalog().transaction(
        [](soci::session& session) { session << "DELETE FROM events WHERE sequence < 3"; });
    EXPECT_EQ(status_since(1), 410);
    EXPECT_EQ(status_since(2), 101);
    EXPECT_EQ(status_since(0), 101);
}

TEST(EventsTest, WithoutSinceTellsOnlyWhatIsNew) {
    TestServer server;
    server.make_dive("default", sha256_hex("1"));
    EventClient client(server.port(), server.admin(), "");
    const auto second = server.make_dive("default", sha256_hex("2"));
    Event event = client.next();
    while (event.topic != "dive") event = client.next();
    EXPECT_EQ(event.subject, second);
}

TEST(EventsTest, TellsOnlyOfTheTokensProject) {
    TestServer server;
    const std::string token = server.make_token("reef", {"dives:read"});
    EventClient client(server.port(), token, "?since=0");
    server.make_dive("wreck", sha256_hex("1"));
    const auto mine = server.make_dive("reef", sha256_hex("2"));
    Event event = client.next();
    EXPECT_EQ(event.project, "reef");
    while (event.topic != "dive") event = client.next();
    EXPECT_EQ(event.subject, mine);
}

TEST(EventsTest, ASlowReaderDelaysNoOtherReaderAndLosesNothing) {
    server::ServerConfig config;
    config.timeouts.web_socket = 300s;  // the slow one answers no ping while it does not read
    TestServer server(config);
    EventClient slow(server.port(), server.admin(), "?since=0");
    EventClient quick(server.port(), server.admin(), "?since=0");
    storage::EventStore events(server.catalog());
    constexpr int kNumEvents = 300;
    server.catalog().transaction([&](soci::session& session) {
        for (int i = 0; i < kNumEvents; ++i) {
            Event event;
            event.project = "default";
            event.topic = "job";
            event.subject = "job_" + std::to_string(i);
            event.type = "job.state";
            event.data = {{"text", std::string(50'000, 'x')}};
            storage::EventStore::append(session, event);
        }
    });
    for (EventClient* client : {&quick, &slow}) {
        EXPECT_EQ(client->next().topic, "audit");  // of the server's first token
        for (int i = 0; i < kNumEvents; ++i)
            EXPECT_EQ(client->next().subject, "job_" + std::to_string(i));
    }
}

TEST(EventsTest, DropsAClientThatGivesNoSignOfLife) {
    server::ServerConfig config;
    config.timeouts.web_socket = 500ms;
    config.timeouts.stop = 30s;
    TestServer server(config);
    EventClient silent(server.port(), server.admin(), "?since=0");  // never reads: no pong
    EventClient alive(server.port(), server.admin(), "?since=0");
    std::this_thread::sleep_for(2s);
    server.make_dive("default", sha256_hex("1"));
    const auto began = std::chrono::steady_clock::now();
    EXPECT_EQ(silent.close_code(), 4408U);
    EXPECT_EQ(silent.close_reason(), "no sign of life for 500 ms: connect again");
    EXPECT_LT(std::chrono::steady_clock::now() - began, 15s);
}

// It cannot be told: no byte gets through to it.
TEST(EventsTest, DropsAClientThatTakesNoMoreBytes) {
    server::ServerConfig config;
    config.timeouts.web_socket = 500ms;
    config.timeouts.stop = 30s;
    TestServer server(config);
    EventClient stuck(server.port(), server.admin(), "?since=0");
    server.catalog().transaction([&](soci::session& session) {
        for (int i = 0; i < 300; ++i) {
            Event event;
            event.project = "default";
            event.topic = "job";
            event.type = "job.state";
            event.data = {{"text", std::string(100'000, 'x')}};
            storage::EventStore::append(session, event);
        }
    });
    const auto dropped = [&] {
        const std::string text = server.request("GET", "/metrics", server.admin()).body;
        return text.find("divemesh_event_streams_dropped_total 1") != std::string::npos;
    };
    const auto end = std::chrono::steady_clock::now() + 15s;
    while (!dropped() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(50ms);
    EXPECT_TRUE(dropped());
}

// Pings go out at half of the time that a client may be silent.
TEST(EventsTest, AWatcherThatAnswersPingsStaysThoughNothingHappens) {
    EXPECT_EQ(server::Timeouts{}.web_socket, 30s);
    server::ServerConfig config;
    config.timeouts.web_socket = 500ms;
    TestServer server(config);
    EventClient client(server.port(), server.admin(), "");
    auto heard = std::async(std::launch::async, [&] { return client.next(); });
    EXPECT_EQ(heard.wait_for(3s), std::future_status::timeout);
    server.make_dive("default", sha256_hex("1"));
    EXPECT_GT(heard.get().sequence, 0);
}

TEST(EventsTest, AStreamEndsWhenItsTokenIsRevoked) {
    TestServer server;
    const auto made = server.post_json(
        "/api/v1/tokens", server.admin(), {{"name", "x"}, {"scopes", {"dives:read"}}});
    EventClient client(server.port(), made.json()["secret"], "?since=0");
    server.make_dive("default", sha256_hex("1"));
    client.next();
    const std::string id = made.json()["id"];
    EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + id, server.admin()).status, 204);
    std::this_thread::sleep_for(1100ms);  // for as long a token that was good is trusted
    server.make_dive("default", sha256_hex("2"));
    EXPECT_EQ(client.close_code(), static_cast<unsigned>(websocket::close_code::policy_error));
    EXPECT_EQ(client.close_reason(),
              "the token was revoked or has expired: connect with a valid one");
}

TEST(EventsTest, AOneShotTokenOpensAStream) {
    TestServer server;
    const auto made =
        server.post_json("/api/v1/one_shot_tokens", server.admin(), {{"path", "/api/v1/events"}});
    const std::string query = "?since=0&one_shot=" + made.json()["secret"].get<std::string>();
    server.make_dive("default", sha256_hex("1"));
    EventClient client(server.port(), "", query);
    EXPECT_EQ(client.next().sequence, 1);
    EXPECT_THROW(EventClient(server.port(), "", query), beast::system_error);
}

TEST(EventsTest, SurvivesWhatAHostileClientSends) {
    TestServer server;
    const auto frame = [](unsigned char first, std::string_view payload) {
        std::string bytes = {static_cast<char>(first), static_cast<char>(0x80 | payload.size())};
        return bytes + std::string(4, '\0') + std::string(payload);  // a mask of zeros
    };
    std::string empty_fragments = frame(0x01, "");
    for (int i = 0; i < 20'000; ++i) empty_fragments += frame(0x00, "");
    std::string pings;
    for (int i = 0; i < 20'000; ++i) pings += frame(0x89, "x");
    const std::string huge = {'\x82', '\xff', 0, 0, 0, 0, 0x40, 0, 0, 0, 0, 0, 0, 0};  // 1 GiB
    for (const std::string& bytes : {empty_fragments,
                                     pings,
                                     huge + std::string(1000, 'x'),
                                     frame(0x81, "\xff\xfe"),   // text that is no UTF-8
                                     frame(0xc1, "deflated?"),  // compression was not agreed on
                                     frame(0x83, "reserved"),
                                     std::string("\x81\x01x", 3),  // not masked
                                     frame(0x88, "\x03")}) {       // half a close code
        RawClient client(server.port());
        const auto opened = open_socket(client, server.admin());
        ASSERT_EQ(opened.status, 101);
        EXPECT_EQ(opened.header("sec-websocket-extensions"), "");
        client.send(bytes);
        client.reset();
    }
    EventClient client(server.port(), server.admin(), "");
    server.make_dive("default", sha256_hex("1"));
    EXPECT_GT(client.next().sequence, 0);
}

TEST(EventsTest, SaysGoodbyeWhenTheServerStops) {
    auto server = std::make_unique<TestServer>();
    EventClient client(server->port(), server->admin(), "?since=0");
    std::thread stopping([&] { server->stop(); });
    EXPECT_EQ(client.close_code(), static_cast<unsigned>(websocket::close_code::going_away));
    EXPECT_EQ(client.close_reason(), "the server stops: connect again in a moment");
    stopping.join();
}

TEST(EventsTest, LeavesAClientThatTalksTooMuch) {
    TestServer server;
    EventClient client(server.port(), server.admin(), "?since=0");
    client.say_text("hello");
    client.say_text(std::string(100'000, 'x'));
    EXPECT_EQ(client.close_code(), static_cast<unsigned>(websocket::close_code::too_big));
    EXPECT_EQ(client.close_reason(), "a message may have 4096 bytes: send smaller ones");
    EXPECT_EQ(server.request("GET", "/healthz/live", "").status, 200);
}

TEST(EventsTest, RefusesWhatIsNoWebSocketOrHasNoRight) {
    TestServer server;
    EXPECT_EQ(server.request("GET", "/api/v1/events", server.admin()).status, 426);
    EXPECT_EQ(server
                  .request("GET",
                           "/api/v1/events?since=x",
                           server.admin(),
                           {{"Upgrade", "websocket"}, {"Connection", "Upgrade"}})
                  .status,
              400);
    EXPECT_THROW(EventClient(server.port(), "dm_wrong", ""), beast::system_error);
    EXPECT_THROW(EventClient(server.port(), server.make_token("reef", {"dives:write"}), ""),
                 beast::system_error);
}

}  // namespace
}  // namespace divemesh
