#include <algorithm>
#include <soci/soci.h>

#include "storage/event_store.hpp"
#include "storage/job_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

class IdempotencyTest : public TusTest {
protected:
    RawResponse ask(const std::string& key,
                    const nlohmann::json& body,
                    const std::string& secret = "") {
        return server.request("POST",
                              "/api/v1/dives/" + dive + "/jobs",
                              secret.empty() ? token : secret,
                              {{"Content-Type", "application/json"}, {"Idempotency-Key", key}},
                              body.dump());
    }
    std::int64_t num_audits() {
        const auto events = storage::EventStore(server.catalog()).since(0, "", 1000);
        return std::count_if(events.begin(), events.end(), [](const Event& event) {
            return event.topic == "audit" && event.data["method"] == "POST";
        });
    }
    std::size_t num_jobs() {
        return server.request("GET", "/api/v1/jobs?kind=reconstruct", token).json()["items"].size();
    }

    const std::string dive = server.make_dive("default", std::string(64, 'a'));
};

// draft-ietf-httpapi-idempotency-key-header-07, section 2.6
TEST_F(IdempotencyTest, ARepeatedRequestIsAnsweredAgainAndNotDoneAgain) {
    const auto first = ask("\"8e03978e-40d5\"", {{"preset", "fast"}});
    EXPECT_EQ(first.status, 201) << first.body;
    EXPECT_EQ(first.header("idempotency-replayed"), "");
    for (const char* key : {"\"8e03978e-40d5\"", "8e03978e-40d5"}) {
        const auto again = ask(key, {{"preset", "fast"}});
        EXPECT_EQ(again.status, 201);
        EXPECT_EQ(again.body, first.body);
        EXPECT_EQ(again.header("location"), first.header("location"));
        EXPECT_EQ(again.header("idempotency-replayed"), "true");
    }
    EXPECT_EQ(num_jobs(), 1U);
    EXPECT_EQ(num_audits(), 1);  // what is not done again is not noted again
}

TEST_F(IdempotencyTest, AKeyIsNoExcuseForAnotherBody) {
    EXPECT_EQ(ask("key", {{"preset", "fast"}}).status, 201);
    EXPECT_EQ(ask("key", {{"preset", "paper"}}).status, 422);
    EXPECT_EQ(num_jobs(), 1U);
}

TEST_F(IdempotencyTest, AKeyBelongsToTheTokenThatUsedIt) {
    const auto first = ask("key", {{"preset", "fast"}});
    const auto stranger = server.make_token("elsewhere", {"dives:read", "jobs:write"});
    EXPECT_EQ(ask("key", {{"preset", "fast"}}, stranger).status, 404);
    const auto colleague = server.make_token("default", {"dives:read", "jobs:write"});
    EXPECT_EQ(ask("key", {{"preset", "paper"}}, colleague).status, 201);
}

TEST_F(IdempotencyTest, HugeAndUnprintableKeysAreRefused) {
    for (const std::string& key : {std::string(),
                                   std::string("\"\""),
                                   std::string(256, 'k'),
                                   std::string("k\xc3\xa9y"),
                                   std::string("a\\b")})
        EXPECT_EQ(ask(key, {{"preset", "fast"}}).status, 400) << key;
    EXPECT_EQ(num_jobs(), 0U);
}

// The catalog is busy with another writer: the first request waits for it.
TEST_F(IdempotencyTest, ASecondRequestWhileTheFirstIsUnderWayIsToldToWait) {
    ask("first", {{"preset", "fast"}});  // the token's use is noted
    RawResponse first;
    RawResponse second;
    std::thread asking;
    server.catalog().transaction([&](soci::session& session) {
        session << "UPDATE schema_version SET version = version";
        asking = std::thread([&] { first = ask("key", {{"preset", "paper"}}); });
        for (int i = 0; i < 200 && second.status != 409; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
            second =
                server.request("POST",
                               "/api/v1/dives/none/jobs",
                               token,
                               {{"Content-Type", "application/json"}, {"Idempotency-Key", "key"}},
                               "{}");
        }
    });
    asking.join();
    EXPECT_EQ(second.status, 409) << second.body;
    EXPECT_EQ(second.header("retry-after"), "2");
    EXPECT_EQ(first.status, 201) << first.body;
    EXPECT_EQ(ask("key", {{"preset", "paper"}}).body, first.body);
    EXPECT_EQ(num_jobs(), 2U);
}

TEST_F(IdempotencyTest, WhatChangesIsRepeatedLikewise) {
    const std::string job = ask("job", {{"preset", "fast"}}).header("location");
    const auto cancel = [&] {
        return server.request("POST", job + "/cancel", token, {{"Idempotency-Key", "cancel"}});
    };
    const auto first = cancel();
    EXPECT_EQ(first.status, 200) << first.body;
    EXPECT_EQ(server.request("POST", job + "/retry", token).status, 200);
    const auto again = cancel();  // does not cancel the new attempt
    EXPECT_EQ(again.body, first.body);
    EXPECT_EQ(again.header("idempotency-replayed"), "true");
    EXPECT_EQ(server.request("GET", job, token).json()["state"], "queued");
}

TEST_F(IdempotencyTest, AnAnswerWithASecretIsNotKept) {
    const auto make = [&](const std::string& path, const nlohmann::json& body) {
        return server.request("POST",
                              path,
                              server.admin(),
                              {{"Content-Type", "application/json"}, {"Idempotency-Key", "key"}},
                              body.dump());
    };
    const nlohmann::json wanted = {{"name", "boat"}, {"scopes", {"dives:read"}}};
    const auto refused = make("/api/v1/tokens", wanted);
    EXPECT_EQ(refused.status, 400);
    EXPECT_NE(refused.json()["detail"].get<std::string>().find("secret"), std::string::npos);
    EXPECT_EQ(server.post_json("/api/v1/tokens", server.admin(), wanted).status, 201);
}

TEST_F(IdempotencyTest, ARefusalIsNotKept) {
    const auto path = create_upload(server.port(), token, 300'000);
    const auto commit = [&] {
        const auto id = path.substr(path.rfind('/') + 1);
        return server.request("POST",
                              "/api/v1/dives",
                              token,
                              {{"Content-Type", "application/json"}, {"Idempotency-Key", "commit"}},
                              nlohmann::json{{"upload_id", id}}.dump());
    };
    EXPECT_EQ(commit().status, 409);
    patch(path, 0, bytes);
    const auto made = commit();
    EXPECT_EQ(made.status, 201) << made.body;
    const auto again = commit();
    EXPECT_EQ(again.status, 201);
    EXPECT_EQ(again.body, made.body);
}

}  // namespace
}  // namespace divemesh
