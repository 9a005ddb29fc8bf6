// A change that is bound to what its client has read (If-Match).
#include <gtest/gtest.h>

#include "schemas/content_hash.hpp"
#include "storage/worker_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

class PreconditionsTest : public testing::Test {
protected:
    std::string tag_of(const std::string& target) {
        return server.request("GET", target, server.admin()).header("etag");
    }
    int ask(const std::string& method,
            const std::string& target,
            const std::string& tags,
            const nlohmann::json& body = nlohmann::json::object()) {
        return server
            .request(method,
                     target,
                     server.admin(),
                     {{"Content-Type", "application/json"}, {"If-Match", tags}},
                     body.dump())
            .status;
    }

    TestServer server;
    const std::string dive = "/api/v1/dives/" + server.make_dive("default", sha256_hex("1"));
    const std::string job =
        server.post_json(dive + "/jobs", server.admin(), {{"preset", "fast"}}).header("location");
};

TEST_F(PreconditionsTest, ALateChangeOfAJobUndoesNoOtherOne) {
    const std::string read = tag_of(job);
    EXPECT_EQ(ask("PATCH", job, read, {{"priority", 5}}), 200);
    EXPECT_EQ(ask("PATCH", job, read, {{"priority", 1}}), 412);
    EXPECT_EQ(server.request("GET", job, server.admin()).json()["priority"], 5);
    EXPECT_EQ(ask("PATCH", job, "\"other\", " + tag_of(job), {{"priority", 1}}), 200);
    EXPECT_EQ(ask("PATCH", job, "*", {{"priority", 2}}), 200);
}

TEST_F(PreconditionsTest, AJobIsCancelledAndRetriedAsItWasRead) {
    EXPECT_EQ(ask("POST", job + "/cancel", "\"other\""), 412);
    const std::string queued = tag_of(job);
    EXPECT_EQ(ask("POST", job + "/cancel", queued), 200);
    EXPECT_EQ(ask("POST", job + "/retry", queued), 412);
    EXPECT_EQ(server.request("GET", job, server.admin()).json()["state"], "cancelled");
    EXPECT_EQ(ask("POST", job + "/retry", tag_of(job)), 200);
}

TEST_F(PreconditionsTest, AQueueIsChangedAsItWasRead) {
    const std::string lab = "/api/v1/queue?project=lab";
    const std::string read = tag_of(lab);
    EXPECT_EQ(ask("PATCH", "/api/v1/queue", read, {{"project", "lab"}, {"max_running", 2}}), 200);
    EXPECT_EQ(ask("PATCH", "/api/v1/queue", read, {{"project", "lab"}, {"max_running", 0}}), 412);
    EXPECT_EQ(server.request("GET", lab, server.admin()).json()["max_running"], 2);
    EXPECT_EQ(ask("POST", "/api/v1/queue/redrive", read, {{"project", "lab"}}), 412);
    EXPECT_EQ(ask("POST", "/api/v1/queue/redrive", tag_of(lab), {{"project", "lab"}}), 200);
}

TEST_F(PreconditionsTest, AWorkerIsDrainedAsItWasRead) {
    storage::WorkerStore(server.catalog()).report("boat", 2);
    const std::string boat = "/api/v1/workers/boat";
    const std::string read = tag_of(boat);
    EXPECT_EQ(ask("PATCH", boat, read, {{"draining", true}}), 200);
    EXPECT_EQ(ask("PATCH", boat, read, {{"draining", false}}), 412);
    EXPECT_EQ(server.request("GET", boat, server.admin()).json()["draining"], true);
    EXPECT_EQ(server.request("GET", "/api/v1/workers/nobody", server.admin()).status, 404);
}

TEST_F(PreconditionsTest, ADiveIsRestoredAsItWasRead) {
    const std::string before = tag_of(dive);
    EXPECT_EQ(ask("DELETE", dive, before), 200);
    EXPECT_EQ(ask("POST", dive + "/restore", before), 412);
    EXPECT_EQ(ask("POST", dive + "/restore", tag_of(dive)), 200);
}

TEST_F(PreconditionsTest, AScheduleIsDeletedAsItWasRead) {
    const std::string schedule =
        server
            .post_json(
                "/api/v1/schedules", server.admin(), {{"cron", "0 4 * * *"}, {"tag", "yearly"}})
            .header("location");
    EXPECT_EQ(ask("DELETE", schedule, "\"other\""), 412);
    EXPECT_EQ(ask("DELETE", schedule, tag_of(schedule)), 204);
}

TEST_F(PreconditionsTest, WhatHasNoTagIsChangedForAnyTagOrNone) {
    const auto made = server.post_json(
        "/api/v1/tokens", server.admin(), {{"name", "n"}, {"scopes", {"dives:read"}}});
    const std::string token = "/api/v1/tokens/" + made.json()["id"].get<std::string>();
    const auto hook =
        server.post_json("/api/v1/webhooks", server.admin(), {{"url", "https://example.org/x"}});
    const std::string webhook = "/api/v1/webhooks/" + hook.json()["id"].get<std::string>();
    for (const std::string& target : {token, webhook}) {
        EXPECT_EQ(ask("DELETE", target, "\"other\""), 412);
        EXPECT_EQ(ask("DELETE", target, ""), 412);
        EXPECT_EQ(ask("DELETE", target, "*"), 204);
    }
    EXPECT_EQ(ask("POST", webhook + "/enable", "\"other\""), 412);
    EXPECT_EQ(ask("POST", webhook + "/deliveries/x/redeliver", "\"other\""), 412);
}

}  // namespace
}  // namespace divemesh
