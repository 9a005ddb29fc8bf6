#include <gtest/gtest.h>

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sstream>

#include "storage/token_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

class TokenTest : public testing::Test {
protected:
    std::string one_shot(const std::string& path, const std::string& token) {
        const auto made = server.post_json("/api/v1/one_shot_tokens", token, {{"path", path}});
        EXPECT_EQ(made.status, 201) << made.body;
        return made.json()["secret"];
    }
    int open(const std::string& path, const std::string& secret) {
        return server.request("GET", path + "?one_shot=" + secret, "").status;
    }
    int create(const nlohmann::json& body) {
        return server.post_json("/api/v1/tokens", server.admin(), body).status;
    }

    TestServer server;
    const std::string reader = server.make_token("reef", {"dives:read"});
    const std::string artifact =
        "/api/v1/jobs/" + server.make_job("reef", "mesh.glb", "glTF") + "/artifacts/mesh.glb";
};

TEST_F(TokenTest, ASensorsTokenNamesItsSensorAndMayNothingElse) {
    const nlohmann::json good = {
        {"name", "rig 1"}, {"scopes", {"sensor:push"}}, {"sensor", "rig-1"}};
    const auto made = server.post_json("/api/v1/tokens", server.admin(), good);
    ASSERT_EQ(made.status, 201) << made.body;
    EXPECT_EQ(made.json()["sensor"], "rig-1");
    const std::string secret = made.json()["secret"];
    EXPECT_EQ(server.request("GET", "/api/v1/dives", secret).status, 403);
    EXPECT_EQ(create({{"name", "x"}, {"scopes", {"sensor:push"}}}), 400);
    EXPECT_EQ(create({{"name", "x"}, {"scopes", {"dives:read"}}, {"sensor", "rig-1"}}), 400);
    EXPECT_EQ(
        create({{"name", "x"}, {"scopes", {"sensor:push", "dives:read"}}, {"sensor", "rig-1"}}),
        400);
    EXPECT_EQ(create({{"name", "x"}, {"scopes", {"sensor:push"}}, {"sensor", "../rig"}}), 400);
}

TEST_F(TokenTest, RefusesTokensThatMakeNoSense) {
    EXPECT_EQ(create({{"name", "x"}, {"scopes", nlohmann::json::array()}}), 400);
    EXPECT_EQ(create({{"name", "x"}, {"scopes", {"root"}}}), 400);
    EXPECT_EQ(create({{"name", ""}, {"scopes", {"admin"}}}), 400);
    EXPECT_EQ(create({{"name", std::string(101, 'x')}, {"scopes", {"admin"}}}), 400);
    EXPECT_EQ(create({{"name", "x"}, {"scopes", {"admin"}}, {"project", "Reef/1"}}), 400);
    EXPECT_EQ(create({{"name", "x"}, {"scopes", {"admin"}}, {"expires_in_s", -1}}), 400);
    EXPECT_EQ(create({{"name", "x"}, {"scopes", {"admin"}}, {"expires_in_s", 1e18}}), 400);
}

TEST_F(TokenTest, AOneShotTokenOpensItsPathOnce) {
    const std::string secret = one_shot(artifact, reader);
    EXPECT_EQ(open("/api/v1/events", secret), 401);
    EXPECT_EQ(open(artifact + "x", secret), 401);
    EXPECT_EQ(server.request("GET", artifact + "?one_shot=" + secret, "").body, "glTF");
    EXPECT_EQ(open(artifact, secret), 401);
    EXPECT_EQ(open(artifact, "dm1_wrong"), 401);
    EXPECT_EQ(open(artifact, ""), 401);
}

TEST_F(TokenTest, ARefusedRequestLeavesAOneShotTokenValid) {
    const std::string secret = one_shot(artifact, reader);
    EXPECT_EQ(server.request("GET", artifact + "?shaa256=1&one_shot=" + secret, "").status, 400);
    EXPECT_EQ(
        server
            .request(
                "GET", artifact + "?sha256=" + std::string(64, 'a') + "&one_shot=" + secret, "")
            .status,
        404);
    EXPECT_EQ(open(artifact, secret), 200);
    EXPECT_EQ(open(artifact, secret), 401);
    const std::string events = one_shot("/api/v1/events", reader);
    EXPECT_EQ(server.request("GET", "/api/v1/events?sinse=0&one_shot=" + events, "").status, 400);
    EXPECT_EQ(open("/api/v1/events", events), 426) << "without Upgrade";
}

// A revoked token ends while a body still arrives, at the latest a second after it was revoked.
TEST_F(TokenTest, ARevokedTokenWritesNoFurther) {
    for (const bool with_checksum : {false, true}) {
        const auto made = server.post_json(
            "/api/v1/tokens", server.admin(), {{"name", "x"}, {"scopes", {"dives:write"}}});
        const std::string token = made.json()["secret"];
        const auto path = create_upload(server.port(), server.admin(), 1'000);
        Headers headers = patch_headers(token, 0);
        if (with_checksum)
            headers.emplace_back("Upload-Checksum", "crc32c " + base64(std::string(4, 'x')));
        RawClient client(server.port());
        client.send(request_head("PATCH", path, headers, 1'000));
        client.send("hello");
        const std::string id = made.json()["id"];
        EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + id, server.admin()).status, 204);
        std::this_thread::sleep_for(std::chrono::milliseconds(1100));
        client.send("of a thief");
        const auto refused = client.receive();
        ASSERT_TRUE(refused);
        EXPECT_EQ(refused->status, 401) << refused->body;
        EXPECT_EQ(upload_offset(server.port(), server.admin(), path), with_checksum ? 0 : 5);
    }
}

TEST_F(TokenTest, ARevokedTokenReadsNoFurther) {
    const std::string large = "/api/v1/jobs/" +
                              server.make_job("default", "cloud.ply", random_bytes(30'000'000)) +
                              "/artifacts/cloud.ply";
    const auto made = server.post_json(
        "/api/v1/tokens", server.admin(), {{"name", "x"}, {"scopes", {"dives:read"}}});
    RawClient client(server.port(), 4096);
    client.send(
        request_head("GET",
                     large,
                     {{"Authorization", "Bearer " + made.json()["secret"].get<std::string>()}},
                     std::nullopt));
    std::size_t received = client.read_available().size();
    const std::string id = made.json()["id"];
    EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + id, server.admin()).status, 204);
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
    for (std::string more = client.read_available(); !more.empty(); more = client.read_available())
        received += more.size();
    EXPECT_LT(received, 25'000'000U);
}

// Clients state what they will open as they write it in an address, with its query.
TEST_F(TokenTest, AOneShotTokenForAPathWithAQueryOpensItWithThatQueryAlone) {
    const std::string zip = artifact.substr(0, artifact.find("/artifacts/")) + "/artifacts.zip";
    const auto made = server.post_json(
        "/api/v1/one_shot_tokens", reader, {{"path", zip + "?names=mesh.glb%2Cx"}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string url = made.json()["url"];
    const std::string secret = made.json()["secret"];
    EXPECT_EQ(open(zip, secret), 401);
    EXPECT_EQ(server.request("GET", zip + "?names=x&one_shot=" + secret, "").status, 401);
    EXPECT_EQ(server.request("GET", url, "").status, 404) << "there is no artifact x";
    const std::string events = one_shot("/api/v1/events?since=0", reader);
    EXPECT_EQ(open("/api/v1/events", events), 401);
    EXPECT_EQ(server.request("GET", "/api/v1/events?one_shot=" + events + "&since=0", "").status,
              426)
        << "the order of the parameters does not count";
    const auto status = [&](const std::string& path) {
        return server.post_json("/api/v1/one_shot_tokens", reader, {{"path", path}}).status;
    };
    EXPECT_EQ(status("/api/v1/events?sinse=0"), 400);
    EXPECT_EQ(status("/api/v1/events?one_shot=x"), 400);
    EXPECT_EQ(status("/api/v1/events?since=%zz"), 400);
}

TEST_F(TokenTest, OfManyWhoRaceForAOneShotTokenOneGetsIn) {
    const std::string secret = one_shot(artifact, reader);
    std::atomic<int> let_in = 0;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < 8; ++i)
            threads.emplace_back([&] { let_in += open(artifact, secret) == 200 ? 1 : 0; });
    }
    EXPECT_EQ(let_in, 1);
}

TEST_F(TokenTest, AOneShotTokenHasNoMoreRightsThanItsMaker) {
    const std::string stranger = server.make_token("wreck", {"dives:read"});
    EXPECT_EQ(open(artifact, one_shot(artifact, stranger)), 404);
    const auto made = server.post_json(
        "/api/v1/tokens", server.admin(), {{"name", "x"}, {"scopes", {"dives:read"}}});
    const std::string secret = one_shot("/api/v1/events", made.json()["secret"]);
    const std::string id = made.json()["id"];
    EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + id, server.admin()).status, 204);
    EXPECT_EQ(open("/api/v1/events", secret), 401);
}

TEST_F(TokenTest, OneShotTokensAreForFilesAndStreamsAlone) {
    for (const std::string path :
         {"/api/v1/dives", "/api/v1/tokens", "", "x", "/api/v1/events#x", "/nothing"})
        EXPECT_EQ(server.post_json("/api/v1/one_shot_tokens", reader, {{"path", path}}).status, 400)
            << path;
    const std::string secret = one_shot(artifact, reader);
    EXPECT_EQ(open("/api/v1/dives", secret), 400);
    EXPECT_EQ(server.request("HEAD", artifact + "?one_shot=" + secret, "").status, 400);
    EXPECT_EQ(server.request("GET", artifact + "?one_shot=" + secret, "").status, 200);
}

TEST_F(TokenTest, AOneShotTokenIsTooOldAfterAWhile) {
    storage::TokenStore tokens(server.catalog());
    const auto owner = tokens.find(reader);
    const auto made = tokens.create_one_shot(*owner, artifact, -1s);
    EXPECT_EQ(open(artifact, made.secret), 401);
    EXPECT_LE(storage::kOneShotLifetime, 30s);
}

TEST_F(TokenTest, NoSecretReachesTheLog) {
    std::ostringstream log;
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
    const std::string secret = one_shot(artifact, reader);
    open(artifact, secret);
    server.request("GET", "/api/v1/dives?token=" + reader, "");
    server.stop();
    spdlog::set_default_logger(before);
    EXPECT_NE(log.str().find("\"event\":\"request\""), std::string::npos);
    EXPECT_EQ(log.str().find(secret), std::string::npos);
    EXPECT_EQ(log.str().find(reader), std::string::npos);
}

}  // namespace
}  // namespace divemesh
