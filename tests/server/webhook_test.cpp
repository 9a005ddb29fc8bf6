#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <mutex>

#include "api/webhook_signature.hpp"
#include "schemas/content_hash.hpp"
#include "storage/webhook_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using namespace std::chrono_literals;

// Answers every POST on a free port of loopback with the status it is told, and keeps what came.
class Receiver {
public:
    using Message = http::request<http::string_body>;

    explicit Receiver(unsigned status, std::string location = "")
        : status_(status), location_(std::move(location)), thread_([this] { run(); }) {}
    ~Receiver() {
        stopping_ = true;
        asio::io_context io;
        asio::ip::tcp::socket socket(io);
        beast::error_code ignored;
        socket.connect(acceptor_.local_endpoint(), ignored);  // wakes it
    }

    std::string url() const {
        return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()) + "/hook";
    }
    std::vector<Message> received() const {
        const std::lock_guard lock(mutex_);
        return received_;
    }
    // Waits for so many; fails the test when they do not come.
    std::vector<Message> wait_for(std::size_t count) const {
        for (int i = 0; i < 1000 && received().size() < count; ++i)
            std::this_thread::sleep_for(10ms);
        EXPECT_GE(received().size(), count);
        return received();
    }
    void answer(unsigned status) { status_ = status; }

private:
    void run() {
        while (!stopping_) {
            asio::ip::tcp::socket socket = acceptor_.accept();
            beast::flat_buffer buffer;
            Message message;
            beast::error_code error;
            http::read(socket, buffer, message, error);
            if (error) continue;
            http::response<http::empty_body> response(http::int_to_status(status_), 11);
            if (!location_.empty()) response.set(http::field::location, location_);
            response.prepare_payload();
            http::write(socket, response, error);
            const std::lock_guard lock(mutex_);
            received_.push_back(std::move(message));
        }
    }

    std::atomic<unsigned> status_;
    std::string location_;
    asio::io_context io_;
    asio::ip::tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
    mutable std::mutex mutex_;
    std::vector<Message> received_;
    std::atomic<bool> stopping_ = false;
    std::jthread thread_;
};

// Takes connections and never answers.
class SilentReceiver {
public:
    SilentReceiver() : thread_([this](const std::stop_token& stop) { run(stop); }) {}
    ~SilentReceiver() {
        thread_.request_stop();
        asio::io_context io;
        asio::ip::tcp::socket socket(io);
        beast::error_code ignored;
        socket.connect(acceptor_.local_endpoint(), ignored);  // wakes it
    }
    std::string url() const {
        return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()) + "/hook";
    }
    int num_connections() const { return num_connections_; }

private:
    void run(const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            sockets_.push_back(acceptor_.accept());
            ++num_connections_;
        }
    }

    asio::io_context io_;
    asio::ip::tcp::acceptor acceptor_{io_, {asio::ip::make_address("127.0.0.1"), 0}};
    std::vector<asio::ip::tcp::socket> sockets_;
    std::atomic<int> num_connections_ = 0;
    std::jthread thread_;
};

server::ServerConfig loopback_may() {
    server::ServerConfig config;
    config.webhook_networks = {"127.0.0.1"};
    return config;
}

class WebhookTest : public testing::Test {
protected:
    nlohmann::json create(const std::string& url, const std::string& topic = "dive") {
        const auto made = server.post_json(
            "/api/v1/webhooks", server.admin(), {{"url", url}, {"topics", {topic}}});
        EXPECT_EQ(made.status, 201) << made.body;
        return made.json();
    }
    nlohmann::json deliveries(const nlohmann::json& webhook) {
        return server.request("GET", path(webhook) + "/deliveries", server.admin()).json()["items"];
    }
    // The first delivery, when it has come so far.
    nlohmann::json delivery(const nlohmann::json& webhook,
                            const std::string& key,
                            const nlohmann::json& value) {
        nlohmann::json found;
        for (int i = 0; i < 1000 && (found.is_null() || found[key] != value); ++i) {
            std::this_thread::sleep_for(10ms);
            const auto all = deliveries(webhook);
            if (!all.empty()) found = all[0];
        }
        EXPECT_EQ(found[key], value) << found.dump();
        return found;
    }
    static std::string path(const nlohmann::json& webhook) {
        return "/api/v1/webhooks/" + webhook["id"].get<std::string>();
    }

    TestServer server{loopback_may()};
};

TEST_F(WebhookTest, TellsAProjectsEventsSignedAndOnce) {
    const Receiver receiver(204);
    const auto webhook = create(receiver.url());
    server.make_dive("elsewhere", sha256_hex("0"));
    const std::string dive = server.make_dive("default", sha256_hex("1"));
    const auto messages = receiver.wait_for(2);  // dive.created, dive.ready
    ASSERT_EQ(messages.size(), 2U);
    for (const auto& message : messages) {
        const auto body = nlohmann::json::parse(message.body());
        EXPECT_EQ(body["data"]["subject"], dive);
        EXPECT_EQ(body["type"], body["data"]["type"]);
        EXPECT_EQ(message["webhook-signature"],
                  api::webhook_signature(webhook["secret"].get<std::string>(),
                                         std::string(message["webhook-id"]),
                                         std::stoll(std::string(message["webhook-timestamp"])),
                                         message.body()));
    }
    EXPECT_NE(messages[0]["webhook-id"], messages[1]["webhook-id"]);
    const auto delivered = delivery(webhook, "state", "delivered");
    EXPECT_EQ(delivered["last_status"], 204);
    EXPECT_EQ(delivered["num_attempts"], 1);
}

TEST_F(WebhookTest, TriesAgainLaterAndRedeliversOnDemand) {
    Receiver receiver(500);
    const auto webhook = create(receiver.url());
    server.make_dive("default", sha256_hex("1"));
    const auto failed = delivery(webhook, "last_status", 500);
    EXPECT_EQ(failed["state"], "waiting");
    EXPECT_GE(failed["next_at_ms"].get<std::int64_t>(),
              failed["created_at_ms"].get<std::int64_t>() + 5000);
    receiver.answer(200);
    const auto again = server.request(
        "POST",
        path(webhook) + "/deliveries/" + failed["id"].get<std::string>() + "/redeliver",
        server.admin());
    EXPECT_EQ(again.status, 200) << again.body;
    EXPECT_EQ(delivery(webhook, "state", "delivered")["id"], failed["id"]);
}

TEST_F(WebhookTest, ADeadReceiverDelaysNoOtherReceiver) {
    const SilentReceiver dead;
    const auto to_dead = create(dead.url());
    const Receiver receiver(204);
    create(receiver.url());
    // Two messages each: more than all that is under way at once would be held up.
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; i < 40; ++i)
        server.make_dive("default", sha256_hex("dive " + std::to_string(i)));
    receiver.wait_for(80);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 10s);  // the dead one is given 15
    EXPECT_EQ(dead.num_connections(), 1);
    EXPECT_EQ(deliveries(to_dead)[0]["state"], "waiting");
}

TEST_F(WebhookTest, WhatWaitsForADisabledWebhookIsSentWhenItIsEnabled) {
    Receiver receiver(500);
    const auto webhook = create(receiver.url());
    server.make_dive("default", sha256_hex("1"));
    const auto failed = delivery(webhook, "last_status", 500);
    receiver.answer(410);
    server.make_dive("default", sha256_hex("2"));
    for (int i = 0; i < 1000; ++i) {
        const auto all = server.request("GET", "/api/v1/webhooks", server.admin()).json()["items"];
        if (all[0]["enabled"] == false) break;
        std::this_thread::sleep_for(10ms);
    }
    const std::string again =
        path(webhook) + "/deliveries/" + failed["id"].get<std::string>() + "/redeliver";
    EXPECT_EQ(server.request("POST", again, server.admin()).json()["state"], "waiting");
    receiver.answer(204);
    const auto so_far = receiver.received().size();
    std::this_thread::sleep_for(1200ms);  // it looks twice a second
    EXPECT_EQ(receiver.received().size(), so_far);
    server.request("POST", path(webhook) + "/enable", server.admin());
    receiver.wait_for(so_far + 1);
    EXPECT_EQ(delivery(webhook, "state", "delivered")["id"], failed["id"]);
}

TEST_F(WebhookTest, AReceiverThatIsGoneIsNotAskedAgain) {
    const Receiver receiver(410);
    const auto webhook = create(receiver.url());
    server.make_dive("default", sha256_hex("1"));
    EXPECT_EQ(delivery(webhook, "state", "failed")["last_status"], 410);
    const auto all = server.request("GET", "/api/v1/webhooks", server.admin()).json()["items"];
    EXPECT_EQ(all[0]["enabled"], false);
    const auto count = deliveries(webhook).size();
    server.make_dive("default", sha256_hex("2"));
    EXPECT_EQ(deliveries(webhook).size(), count);
    EXPECT_EQ(server.request("POST", path(webhook) + "/enable", server.admin()).json()["enabled"],
              true);
}

TEST_F(WebhookTest, FollowsNoRedirect) {
    const Receiver secret(200);
    const Receiver receiver(302, secret.url());
    const auto webhook = create(receiver.url());
    server.make_dive("default", sha256_hex("1"));
    EXPECT_EQ(delivery(webhook, "last_status", 302)["state"], "waiting");
    EXPECT_TRUE(secret.received().empty());
}

// The address is resolved and checked at each delivery.
TEST_F(WebhookTest, ReachesNothingThatIsNotAllowed) {
    for (const char* url : {"http://127.0.0.2:9000/",
                            "http://[::1]:9000/",
                            "https://169.254.169.254/latest/meta-data",
                            "https://10.0.0.1/",
                            "https://[::ffff:127.0.0.1]/",
                            "http://example.org/",
                            "https://2130706433/"})
        EXPECT_EQ(server.post_json("/api/v1/webhooks", server.admin(), {{"url", url}}).status, 400)
            << url;
    Webhook planted;
    planted.project = "default";
    planted.url = "https://localhost:9000/";  // a name: ::1 too
    planted.topics = {"dive"};
    planted = storage::WebhookStore(server.catalog()).create(planted, "whsec_AAAA");
    server.make_dive("default", sha256_hex("1"));
    const auto refused = delivery({{"id", planted.id}}, "num_attempts", 1);
    EXPECT_EQ(refused["last_status"], 0);
}

TEST_F(WebhookTest, ShowsItsSecretOnce) {
    const auto webhook = create("https://example.org/");
    const std::string secret = webhook["secret"];
    EXPECT_TRUE(secret.starts_with("whsec_"));
    const auto list = server.request("GET", "/api/v1/webhooks", server.admin());
    EXPECT_EQ(list.body.find(secret), std::string::npos);
    EXPECT_EQ(list.body.find("secret"), std::string::npos);
    EXPECT_EQ(server.request("DELETE", path(webhook), server.admin()).status, 204);
    EXPECT_EQ(server.request("DELETE", path(webhook), server.admin()).status, 404);
}

TEST_F(WebhookTest, RefusesTopicsThatAreNone) {
    for (const nlohmann::json& body :
         {nlohmann::json{{"url", "https://example.org/"}, {"topics", {"audit"}}},
          nlohmann::json{{"url", "https://example.org/"}, {"topics", nlohmann::json::array()}},
          nlohmann::json{{"url", "https://example.org/"}, {"topics", "dive"}},
          nlohmann::json{{"topics", {"dive"}}}})
        EXPECT_EQ(server.post_json("/api/v1/webhooks", server.admin(), body).status, 400)
            << body.dump();
}

}  // namespace
}  // namespace divemesh
