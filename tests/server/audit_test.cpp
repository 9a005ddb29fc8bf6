// Who changed what: every route that changes something leaves an audit event.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <soci/soci.h>

#include "api/routes.hpp"
#include "storage/event_store.hpp"
#include "storage/sensor_store.hpp"
#include "storage/upload_store.hpp"
#include "storage/worker_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

class AuditTest : public TusTest {
protected:
    // Returns the events of requests: what the server does by itself has no method.
    std::vector<Event> audits() {
        std::vector<Event> found;
        for (Event& event : storage::EventStore(server.catalog()).since(0, "", 1000))
            if (event.topic == "audit" && event.data["method"] != "")
                found.push_back(std::move(event));
        return found;
    }
    RawResponse ask(const std::string& method,
                    const std::string& target,
                    const nlohmann::json& body = nlohmann::json::object()) {
        return server.request(method,
                              target,
                              token,
                              {{"Content-Type", "application/json"}, {"If-Match", "*"}},
                              body.dump());
    }
    std::string new_dive() {
        EXPECT_FALSE(dives_.empty());
        const std::string dive = "/api/v1/dives/" + dives_.back();
        dives_.pop_back();
        return dive;
    }
    std::string new_job() {
        const auto made = ask("POST", new_dive() + "/jobs");
        EXPECT_EQ(made.status, 201) << made.body;
        return made.header("location");
    }
    std::string cancelled_job() {
        const auto job = new_job();
        ask("POST", job + "/cancel");
        return job;
    }
    std::string deleted_dive() {
        const auto dive = new_dive();
        ask("DELETE", dive);
        return dive;
    }
    std::string whole_upload() {
        const auto path = create_upload(server.port(), token, 5);
        patch(path, 0, std::to_string(10'000 + ++num_made_));
        return path.substr(path.rfind('/') + 1);
    }
    std::string new_webhook() {
        const auto made = ask(
            "POST", "/api/v1/webhooks", {{"url", "https://example.org/"}, {"topics", {"dive"}}});
        EXPECT_EQ(made.status, 201) << made.body;
        return "/api/v1/webhooks/" + made.json()["id"].get<std::string>();
    }
    // Returns the path of an event that is not sent yet, or could not be.
    std::string new_delivery() {
        const auto webhook = new_webhook();
        deleted_dive();
        const auto all = ask("GET", webhook + "/deliveries").json()["items"];
        EXPECT_FALSE(all.empty());
        return webhook + "/deliveries/" + all[0]["id"].get<std::string>();
    }
    std::string new_truth() {
        const auto dive = new_dive();
        const std::string kind = "truth " + base64("areas") + ",dive_id ";
        const auto path =
            create_upload(server.port(), token, 4, kind + base64(dive.substr(dive.rfind('/') + 1)));
        return dive + "/truth/" + patch(path, 0, "text").header("divemesh-truth");
    }
    std::string new_schedule() {
        const auto made =
            ask("POST", "/api/v1/schedules", {{"cron", "0 4 * * *"}, {"tag", "yearly"}});
        EXPECT_EQ(made.status, 201) << made.body;
        return made.header("location");
    }
    std::string worker_at_work() {
        const std::string name = "boat:" + std::to_string(++num_made_);
        storage::WorkerStore(server.catalog()).report(name, 1);
        return "/api/v1/workers/" + name;
    }
    std::string new_token() {
        const auto made =
            ask("POST", "/api/v1/tokens", {{"name", "laptop"}, {"scopes", {"dives:read"}}});
        return "/api/v1/tokens/" + made.json()["id"].get<std::string>();
    }

    RawResponse sign_out() {
        const auto begun = ask("POST", "/api/v1/session");
        const std::string cookie = begun.header("set-cookie");
        return server.request("DELETE",
                              "/api/v1/session",
                              "",
                              {{"Cookie", cookie.substr(0, cookie.find(';'))},
                               {"X-CSRF-Token", begun.json()["csrf_token"]}});
    }
    std::string willing_sensor() {
        SensorMessage hello{.kind = MessageKind::Hello};
        hello.body = {{"capabilities", {"start_recording"}}};
        storage::SensorStore(server.catalog())
            .receive({{"aqua", "default", {"boot", {hello}, {}}}});
        return "/api/v1/sensors/aqua";
    }

    // A request of each route that succeeds.
    using Change = std::function<RawResponse()>;
    std::map<std::string, Change> changes() {
        return {
            // clang-format off
            {"POST /api/v1/uploads", [this] { return create({{"Upload-Length", "9"}}); }},
            {"PATCH /api/v1/uploads/{upload_id}",
             [this] { return patch(create_upload(server.port(), token, 4), 0, "last"); }},
            {"DELETE /api/v1/uploads/{upload_id}",
             [this] { return terminate(create_upload(server.port(), token, 4)); }},
            {"POST /api/v1/dives",
             [this] { return ask("POST", "/api/v1/dives", {{"upload_id", whole_upload()}}); }},
            {"PATCH /api/v1/dives/{dive_id}",
             [this] { return ask("PATCH", new_dive(), {{"site", "Reef 3"}}); }},
            {"DELETE /api/v1/dives/{dive_id}", [this] { return ask("DELETE", new_dive()); }},
            {"POST /api/v1/dives/{dive_id}/restore",
             [this] { return ask("POST", deleted_dive() + "/restore"); }},
            {"POST /api/v1/dives/{dive_id}/jobs",
             [this] { return ask("POST", new_dive() + "/jobs"); }},
            {"DELETE /api/v1/dives/{dive_id}/truth/{truth_id}",
             [this] { return ask("DELETE", new_truth()); }},
            {"POST /api/v1/schedules",
             [this] { return ask("POST", "/api/v1/schedules", {{"cron", "0 4 * * *"}, {"tag", "yearly"}}); }},
            {"DELETE /api/v1/schedules/{schedule_id}", [this] { return ask("DELETE", new_schedule()); }},
            {"PATCH /api/v1/jobs/{job_id}",
             [this] { return ask("PATCH", new_job(), {{"priority", 5}}); }},
            {"POST /api/v1/jobs/{job_id}/cancel",
             [this] { return ask("POST", new_job() + "/cancel"); }},
            {"POST /api/v1/jobs/{job_id}/retry",
             [this] { return ask("POST", cancelled_job() + "/retry"); }},
            {"DELETE /api/v1/jobs/{job_id}", [this] { return ask("DELETE", cancelled_job()); }},
            {"POST /api/v1/jobs/{job_id}/restore",
             [this] {
                 const std::string job = cancelled_job();
                 ask("DELETE", job);
                 return ask("POST", job + "/restore");
             }},
            {"POST /api/v1/jobs/{job_id}/shares", [this] { return ask("POST", job_with_result_ + "/shares"); }},
            {"DELETE /api/v1/jobs/{job_id}/shares/{share_id}",
             [this] {
                 const std::string shares = job_with_result_ + "/shares";
                 return ask("DELETE", shares + "/" + ask("POST", shares).json()["id"].get<std::string>());
             }},
            {"PATCH /api/v1/queue",
             [this] { return ask("PATCH", "/api/v1/queue", {{"max_running", 3}}); }},
            {"POST /api/v1/queue/redrive",
             [this] { return ask("POST", "/api/v1/queue/redrive", {{"limit", 5}}); }},
            {"PATCH /api/v1/workers/{worker_name}",
             [this] { return ask("PATCH", worker_at_work(), {{"draining", true}}); }},
            {"POST /api/v1/sensors/{sensor_id}/commands",
             [this] { return ask("POST", willing_sensor() + "/commands", {{"name", "start_recording"}}); }},
            {"POST /api/v1/tokens",
             [this] { return ask("POST", "/api/v1/tokens", {{"name", "tablet"}, {"scopes", {"dives:read"}}}); }},
            {"DELETE /api/v1/tokens/{token_id}", [this] { return ask("DELETE", new_token()); }},
            {"POST /api/v1/one_shot_tokens", [this] { return ask("POST", "/api/v1/one_shot_tokens", {{"path", "/api/v1/events"}}); }},
            {"POST /api/v1/session", [this] { return ask("POST", "/api/v1/session"); }},
            {"DELETE /api/v1/session", [this] { return sign_out(); }},
            {"POST /api/v1/webhooks",
             [this] { return ask("POST", "/api/v1/webhooks", {{"url", "https://example.org/"}}); }},
            {"DELETE /api/v1/webhooks/{webhook_id}", [this] { return ask("DELETE", new_webhook()); }},
            {"POST /api/v1/webhooks/{webhook_id}/enable",
             [this] { return ask("POST", new_webhook() + "/enable"); }},
            {"POST /api/v1/webhooks/{webhook_id}/deliveries/{delivery_id}/redeliver",
             [this] { return ask("POST", new_delivery() + "/redeliver"); }},
            // clang-format on
        };
    }

private:
    // All of them before the first job: to make one takes what is queued.
    std::vector<std::string> make_dives() {
        std::vector<std::string> dives;
        constexpr int kNumDives = 19;  // at least one for each new_dive() of changes()
        for (int i = 0; i < kNumDives; ++i)
            dives.push_back(server.make_dive("default", sha256_hex(std::to_string(i))));
        return dives;
    }

    // Before any job is queued: to make one takes what is queued.
    const std::string job_with_result_ =
        "/api/v1/jobs/" + server.make_job("default", "report.html", "<p>");
    std::vector<std::string> dives_ = make_dives();
    int num_made_ = 0;
};

// Returns true if the audit log covers the route. Reports of a sensor are not audited: the history
// of the sensor is their log.
bool changes_something(const api::Route& route) {
    using enum api::verb;
    return route.scope != "sensor:push" && route.method != get && route.method != head &&
           route.method != options;
}

TEST_F(AuditTest, EveryRouteThatChangesSomethingLeavesAnEvent) {
    const auto change_of = changes();
    std::size_t num_changes = 0;
    for (const api::Route& route : api::api_routes()) {
        if (!changes_something(route)) continue;
        const std::string method(api::http::to_string(route.method));
        const auto change = change_of.find(method + " " + std::string(route.path));
        ASSERT_NE(change, change_of.end()) << method << " " << route.path << " has no example here";
        const auto answer = change->second();
        EXPECT_EQ(answer.status / 100, 2) << change->first << ": " << answer.body;
        const auto all = audits();
        ASSERT_FALSE(all.empty()) << change->first;
        const auto is_its = [&](const Event& event) {
            return event.data["request_id"] == answer.header("x-request-id");
        };
        EXPECT_TRUE(is_its(all.back())) << change->first;
        EXPECT_EQ(std::count_if(all.begin(), all.end(), is_its), 1) << change->first;
        EXPECT_EQ(all.back().data["method"], method) << change->first;
        ++num_changes;
    }
    EXPECT_EQ(num_changes, change_of.size()) << "an example is of no route";
}

TEST_F(AuditTest, AnUploadInManyPiecesLeavesItsCreationAndItsCompletion) {
    const auto path = create_upload(server.port(), token, 10);
    for (int i = 0; i < 10; ++i) EXPECT_EQ(patch(path, i, "x").status, 204);
    EXPECT_EQ(patch(path, 10, "").status, 204);  // again: nothing changes
    const auto all = audits();
    ASSERT_EQ(all.size(), 2U);
    EXPECT_FALSE(all[0].data.contains("uploaded_bytes"));
    EXPECT_EQ(all[1].data["uploaded_bytes"], 10);
    EXPECT_EQ(all[1].data["path"], path);
    EXPECT_EQ(all[1].data["peer"], "127.0.0.1");
}

TEST_F(AuditTest, AnUploadThatIsWholeAtOnceSaysSo) {
    create({{"Upload-Length", "5"}, {"Content-Type", "application/offset+octet-stream"}}, "whole");
    const auto part = make_part("part");
    create({{"Upload-Concat", final_of({part, part})}});
    const auto all = audits();
    ASSERT_EQ(all.size(), 6U) << "the upload, and that its bytes are there";
    for (const auto i : {0U, 2U, 4U}) EXPECT_FALSE(all[i].data.contains("uploaded_bytes"));
    EXPECT_EQ(all[1].data["uploaded_bytes"], 5);
    EXPECT_EQ(all[3].data["uploaded_bytes"], 4);
    EXPECT_EQ(all[5].data["uploaded_bytes"], 8);
}

TEST_F(AuditTest, ADiveThatItsLastBytesMakeIsToldOnceAndWithThem) {
    const auto path = create_upload(server.port(), token, 5, "commit");
    const auto made = patch(path, 0, "bytes");
    EXPECT_EQ(patch(path, 5, "").status, 204);  // again: it is a dive already
    const auto all = audits();
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[1].data["uploaded_bytes"], 5);
    EXPECT_EQ(all[1].data["request_id"], made.header("x-request-id"));
}

TEST_F(AuditTest, BytesThatMakeNoDiveAreToldAllTheSame) {
    const auto path = create_upload(
        server.port(), token, 5, "commit,sha256 " + base64(sha256_hex("something else")));
    EXPECT_EQ(patch(path, 0, "bytes").status, 422);
    const auto all = audits();
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[1].data["uploaded_bytes"], 5);
}

// The event is part of the change: a catalog that takes no such event takes no change.
TEST_F(AuditTest, WhatCannotBeNotedDoesNotHappen) {
    const auto job = new_job();
    const auto dive = new_dive();
    const auto upload = create_upload(server.port(), token, 4);
    const auto tokens = ask("GET", "/api/v1/tokens").json();
    server.catalog().transaction([](soci::session& session) {
        session << "CREATE TRIGGER no_audits BEFORE INSERT ON events WHEN NEW.topic = 'audit'"
                   " BEGIN SELECT RAISE(ABORT, 'no'); END";
    });
    EXPECT_EQ(ask("POST", job + "/cancel").status, 500);
    EXPECT_EQ(ask("PATCH", job, {{"priority", 7}}).status, 500);
    EXPECT_EQ(ask("DELETE", dive).status, 500);
    EXPECT_EQ(ask("PATCH", "/api/v1/queue", {{"max_running", 3}}).status, 500);
    EXPECT_EQ(ask("POST", "/api/v1/tokens", {{"name", "x"}, {"scopes", {"admin"}}}).status, 500);
    EXPECT_EQ(ask("POST", "/api/v1/webhooks", {{"url", "https://example.org/"}}).status, 500);
    EXPECT_EQ(create({{"Upload-Length", "9"}}).status, 500);
    EXPECT_EQ(terminate(upload).status, 500);

    EXPECT_EQ(ask("GET", job).json()["state"], "queued");
    EXPECT_EQ(ask("GET", job).json()["priority"], 0);
    EXPECT_EQ(ask("GET", dive).json()["deleted_at_ms"], 0);
    EXPECT_EQ(ask("GET", "/api/v1/queue").json()["max_running"], 0);
    EXPECT_EQ(ask("GET", "/api/v1/tokens").json()["items"].size(), tokens["items"].size());
    EXPECT_TRUE(ask("GET", "/api/v1/webhooks").json()["items"].empty());
    EXPECT_EQ(head(upload).status, 200);
    EXPECT_EQ(storage::UploadStore(server.catalog()).list_open().size(), 1U);
}

TEST_F(AuditTest, WhatIsRefusedOrReadLeavesNone) {
    const auto path = create_upload(server.port(), token, 10);
    const auto num_before = audits().size();
    EXPECT_EQ(patch(path, 5, "x").status, 409);
    EXPECT_EQ(head(path).status, 200);
    EXPECT_EQ(ask("DELETE", "/api/v1/tokens/tok_none").status, 404);
    EXPECT_EQ(ask("PATCH", "/api/v1/queue", {{"max_running", -1}}).status, 400);
    EXPECT_EQ(ask("GET", "/api/v1/tokens").status, 200);
    EXPECT_EQ(audits().size(), num_before);
}

}  // namespace
}  // namespace divemesh
