// The queue over HTTP.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "storage/event_store.hpp"
#include "storage/job_store.hpp"
#include "storage/worker_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

class QueueTest : public testing::Test {
protected:
    RawResponse get(const std::string& target) { return server.request("GET", target, token); }
    RawResponse post(const std::string& target, const nlohmann::json& body) {
        return server.post_json(target, token, body);
    }
    RawResponse patch(const std::string& target, const nlohmann::json& body) {
        return patch_as(token, target, body);
    }
    RawResponse patch_as(const std::string& whose,
                         const std::string& target,
                         const nlohmann::json& body) {
        return server.request(
            "PATCH", target, whose, {{"Content-Type", "application/json"}}, body.dump());
    }
    // A reconstruction of the one dive; its path.
    std::string ask(nlohmann::json body = nlohmann::json::object()) {
        body["options"] = {{"seed", ++num_jobs}};
        const auto made = post(jobs_of_dive, body);
        EXPECT_EQ(made.status, 201) << made.body;
        return made.header("location");
    }
    void run_and_fail(const std::string& log) {
        storage::JobStore jobs(server.catalog());
        const auto claim = jobs.claim("worker", std::chrono::minutes(1));
        ASSERT_TRUE(claim);
        jobs.append_log(claim->lease, log);
        jobs.fail(claim->lease, {ErrorCode::BadData, "no frames"});
    }
    static std::string id_of(const std::string& path) { return path.substr(path.rfind('/') + 1); }

    TestServer server;
    const std::string token = server.admin();
    const std::string jobs_of_dive =
        "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a')) + "/jobs";
    int num_jobs = 0;
};

TEST_F(QueueTest, EveryAnswerAndEventSaysWhyAJobWaits) {
    const auto made = post(jobs_of_dive, nlohmann::json::object());
    const std::string job = made.header("location");
    const auto last_event = [&] {
        const auto events = storage::EventStore(server.catalog()).since(0, "", 1000);
        const auto last = std::find_if(events.rbegin(), events.rend(), [](const Event& event) {
            return event.topic == "job";
        });
        return last == events.rend() ? nlohmann::json() : last->data;
    };
    EXPECT_EQ(made.json()["waits_for"], "worker");
    EXPECT_EQ(last_event()["waits_for"], "worker");
    EXPECT_EQ(patch(job, {{"paused", true}}).json()["waits_for"], "paused");
    EXPECT_EQ(last_event()["waits_for"], "paused");
    const auto resumed = patch(job, {{"paused", false}});
    EXPECT_EQ(resumed.json(), get(job).json());
    const auto cancelled = post(job + "/cancel", nlohmann::json::object());
    EXPECT_FALSE(cancelled.json().contains("waits_for"));
    EXPECT_FALSE(last_event().contains("waits_for"));
    const auto retried = post(job + "/retry", nlohmann::json::object());
    EXPECT_EQ(retried.json()["waits_for"], "worker");
    EXPECT_EQ(retried.json(), get(job).json());
    EXPECT_EQ(last_event()["waits_for"], "worker");
}

TEST_F(QueueTest, TellsAQueuedJobWhereItStands) {
    ask();
    const std::string second = ask();

    EXPECT_EQ(get(second).json()["forecast"]["position"], 2);
    EXPECT_FALSE(get(second).json()["forecast"].contains("starts_in_s"));  // no worker polls
    EXPECT_EQ(get(second).json()["waits_for"], "worker");
    const nlohmann::json queued = get("/api/v1/jobs?state=queued").json();
    ASSERT_GE(queued["items"].size(), 2U);
    for (const auto& job : queued["items"]) EXPECT_TRUE(job["forecast"].is_object());
    server.request("POST", second + "/cancel", token);
    EXPECT_TRUE(get(second).json()["forecast"].is_null());
    EXPECT_FALSE(get(second).json().contains("waits_for"));
}

TEST_F(QueueTest, SaysWhatKeepsAJobAndTheQueue) {
    const auto queue_waits_for = [&] {
        return get("/healthz/ready").json().value("queue_waits_for", "");
    };
    storage::WorkerStore workers(server.catalog());
    workers.report("worker", 1, "disk");
    const std::string job = ask();
    const std::string child = ask({{"parents", {id_of(job)}}});

    EXPECT_EQ(get(job).json()["waits_for"], "disk");
    EXPECT_EQ(get(job).json()["forecast"], nlohmann::json({{"position", 1}}));
    EXPECT_EQ(get(child).json()["waits_for"], "parent");
    EXPECT_EQ(get(child + "?fields=waits_for").json(), nlohmann::json({{"waits_for", "parent"}}));
    EXPECT_EQ(get("/api/v1/jobs?state=queued").json()["items"][0]["waits_for"], "disk");
    EXPECT_EQ(get("/api/v1/workers").json()["items"][0]["waits_for"], "disk");
    EXPECT_EQ(queue_waits_for(), "disk");
    workers.report("worker", 1);
    for (int i = 0; i < 500 && get(job).json().contains("waits_for"); ++i)  // a snapshot is kept
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    EXPECT_FALSE(get(job).json().contains("waits_for"));
    EXPECT_EQ(get(job).json()["forecast"]["starts_in_s"], 0.0);
    EXPECT_FALSE(get("/api/v1/workers").json()["items"][0].contains("waits_for"));
    EXPECT_EQ(queue_waits_for(), "");
}

TEST_F(QueueTest, ChangesAJobThatWaits) {
    const std::string job = ask();

    EXPECT_EQ(patch(job, {{"priority", 5}}).json()["priority"], 5);
    EXPECT_EQ(patch(job, {{"paused", true}}).json()["state"], "held");
    EXPECT_EQ(patch(job, {{"paused", false}}).json()["state"], "queued");
    EXPECT_EQ(patch(job, {{"priority", 101}}).status, 400);
    EXPECT_EQ(patch(job, {{"paused", 1}}).status, 400);
    EXPECT_EQ(patch(job, {{"state", "running"}}).status, 400);
    server.request("POST", job + "/cancel", token);
    EXPECT_EQ(patch(job, {{"priority", 5}}).status, 409);
}

TEST_F(QueueTest, HoldsAJobBehindItsParents) {
    const std::string parent = ask();
    const std::string child = ask({{"parents", {id_of(parent)}}});
    EXPECT_EQ(get(child).json()["state"], "held");
    EXPECT_EQ(get(child).json()["parents"], nlohmann::json({id_of(parent)}));

    server.request("POST", parent + "/cancel", token);

    EXPECT_EQ(get(child).json()["state"], "failed");
    EXPECT_EQ(get(child).json()["failure"]["remedy"],
              "retry job " + id_of(parent) + ": this one then waits for it again");
    EXPECT_EQ(post(jobs_of_dive, {{"parents", {id_of(parent)}}}).status, 409);
    EXPECT_EQ(post(jobs_of_dive, {{"parents", {"job_none"}}}).status, 404);
    EXPECT_EQ(post(jobs_of_dive, {{"parents", "job_none"}}).status, 400);
}

TEST(DiskGuardTest, NoJobIsPutBackWhileTheDiskIsNearlyFull) {
    server::ServerConfig config;
    config.min_free_bytes = std::int64_t{1} << 60;
    TestServer server(config);
    storage::JobStore jobs(server.catalog());
    storage::NewJob wanted{.dive_id = server.make_dive("default", std::string(64, 'a')),
                           .preset = "fast",
                           .max_attempts = 1};
    const std::string id = jobs.enqueue(wanted).job.id;
    jobs.fail(jobs.claim("worker", std::chrono::minutes(1))->lease,
              {ErrorCode::Unavailable, "crashed"});
    const std::string job = "/api/v1/jobs/" + id;

    EXPECT_EQ(server.request("POST", job + "/retry", server.admin()).status, 507);
    EXPECT_EQ(server.post_json("/api/v1/queue/redrive", server.admin(), {{"limit", 5}}).status,
              507);
    EXPECT_EQ(server.request("GET", job, server.admin()).json()["state"], "dead");
}

TEST_F(QueueTest, ListsJobsByTheTimeTheyWereMade) {
    const auto made_ms = get(ask()).json()["created_at_ms"].get<std::int64_t>();
    const auto listed = [&](const std::string& query) {
        return get("/api/v1/jobs?kind=reconstruct&" + query).json()["items"].size();
    };
    EXPECT_EQ(listed("created_after_ms=" + std::to_string(made_ms - 1)), 1U);
    EXPECT_EQ(listed("created_after_ms=" + std::to_string(made_ms)), 0U);
    EXPECT_EQ(listed("created_before_ms=" + std::to_string(made_ms)), 0U);
    EXPECT_EQ(listed("created_before_ms=" + std::to_string(made_ms + 1)), 1U);
    EXPECT_EQ(get("/api/v1/jobs?created_after_ms=-1").status, 400);
}

TEST_F(QueueTest, AsksForTheSameWorkOnce) {
    const nlohmann::json body = {{"preset", "fast"}};
    const auto first = post(jobs_of_dive, body);
    const auto second = post(jobs_of_dive, body);

    EXPECT_EQ(first.status, 201);
    EXPECT_EQ(second.status, 200);
    EXPECT_EQ(second.header("location"), first.header("location"));
}

TEST_F(QueueTest, ShowsEveryAttemptItsFailureAndItsLog) {
    const std::string job = ask();
    run_and_fail("first\n");
    server.request("POST", job + "/retry", token);
    run_and_fail("second\n");

    const auto attempts = get(job + "/attempts").json()["items"];
    ASSERT_EQ(attempts.size(), 2U);
    EXPECT_EQ(attempts[0]["number"], 1);
    EXPECT_EQ(attempts[0]["failure"]["message"], "no frames");
    EXPECT_NE(attempts[0]["failure"]["remedy"], "");
    EXPECT_EQ(get(job + "/attempts/1/log").body, "first\n");
    EXPECT_EQ(get(job + "/attempts/2/log").body, "second\n");
    EXPECT_EQ(get(job + "/log").body, "second\n");
    for (const char* number : {"3", "0", "-1", "x", "99999999999999999999"})
        EXPECT_EQ(get(job + "/attempts/" + number + "/log").status, 404) << number;
}

TEST_F(QueueTest, PausesAndLimitsByTheAdministratorAlone) {
    const std::string lab = server.make_token("lab", {"dives:read", "jobs:write"});
    ask();

    const auto paused = patch("/api/v1/queue", {{"paused", true}, {"max_running", 2}});
    EXPECT_EQ(paused.status, 200) << paused.body;
    EXPECT_EQ(get("/api/v1/queue").json()["paused"], true);
    EXPECT_EQ(get("/api/v1/queue").json()["max_running"], 2);
    EXPECT_EQ(get("/api/v1/queue").json()["num_jobs"]["queued"], 1);
    EXPECT_EQ(get("/api/v1/queue?project=lab").json()["paused"], false);
    EXPECT_EQ(server.request("GET", "/api/v1/queue", lab).json()["project"], "lab");
    EXPECT_EQ(server.request("GET", "/api/v1/queue?project=default", lab).status, 404);
    EXPECT_EQ(patch_as(lab, "/api/v1/queue", {{"paused", false}}).status, 403);
    EXPECT_EQ(patch("/api/v1/queue", {{"max_running", -1}}).status, 400);
    EXPECT_EQ(patch("/api/v1/queue", {{"paused", "yes"}}).status, 400);
}

TEST_F(QueueTest, RedrivesTheDeadOfAProject) {
    const std::string job = ask();
    storage::JobStore jobs(server.catalog(), {.first = std::chrono::milliseconds(0)});
    for (int i = 0; i < 3; ++i)
        jobs.fail(jobs.claim("worker", std::chrono::minutes(1))->lease,
                  {ErrorCode::Unavailable, "crashed"});
    ASSERT_EQ(get(job).json()["state"], "dead");
    const std::string lab = server.make_token("lab", {"jobs:write"});

    EXPECT_EQ(
        server.post_json("/api/v1/queue/redrive", lab, {{"limit", 10}}).json()["items"].size(), 0U);
    EXPECT_EQ(server.post_json("/api/v1/queue/redrive", lab, {{"project", "default"}}).status, 404);
    const auto driven = post("/api/v1/queue/redrive", {{"limit", 10}});

    ASSERT_EQ(driven.json()["items"].size(), 1U) << driven.body;
    EXPECT_EQ(get(job).json()["state"], "queued");
    EXPECT_EQ(post("/api/v1/queue/redrive", {{"limit", 0}}).status, 400);
}

TEST_F(QueueTest, DrainsAWorker) {
    storage::WorkerStore(server.catalog()).report("boat:7:ab", 2);
    ask();

    const auto drained = patch("/api/v1/workers/boat%3A7%3Aab", {{"draining", true}});
    EXPECT_EQ(drained.status, 200) << drained.body;
    EXPECT_EQ(get("/api/v1/workers").json()["items"][0]["draining"], true);
    storage::JobStore jobs(server.catalog());
    EXPECT_FALSE(jobs.claim("boat:7:ab", std::chrono::minutes(1)));
    EXPECT_TRUE(jobs.claim("another", std::chrono::minutes(1)));
    EXPECT_EQ(patch("/api/v1/workers/nobody", {{"draining", true}}).status, 404);
    EXPECT_EQ(patch("/api/v1/workers/boat:7:ab", nlohmann::json::object()).status, 400);
    const std::string lab = server.make_token("lab", {"dives:read", "jobs:write"});
    EXPECT_EQ(server.request("GET", "/api/v1/workers", lab).status, 403);
}

}  // namespace
}  // namespace divemesh
