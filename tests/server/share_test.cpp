// Sharing links: what they open, for how long, and who is told.
#include <gmock/gmock.h>
#include <soci/soci.h>

#include "api/routes.hpp"
#include "storage/event_store.hpp"
#include "storage/share_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

class ShareTest : public testing::Test {
protected:
    nlohmann::json share(const nlohmann::json& wanted = nlohmann::json::object()) {
        const auto made = server.post_json(job + "/shares", writer, wanted);
        EXPECT_EQ(made.status, 201) << made.body;
        EXPECT_EQ(made.header("cache-control"), "no-store");
        return made.json();
    }
    RawResponse get(const std::string& path, const std::string& secret) {
        return server.request("GET", path, secret);
    }
    int withdraw(const std::string& id) {
        return server.request("DELETE", job + "/shares/" + id, writer, {{"If-Match", "*"}}).status;
    }
    std::vector<Event> visits() {
        std::vector<Event> found;
        for (Event& event : storage::EventStore(server.catalog()).since(0, "", 1000))
            if (event.type == "audit.visit") found.push_back(std::move(event));
        return found;
    }
    // Moves the end of all links into the past.
    void let_links_expire() {
        server.catalog().transaction([](soci::session& session) {
            session << "UPDATE tokens SET expires_at_ms = 1 WHERE shared_job <> ''";
        });
    }

    TestServer server;
    const std::string writer =
        server.make_token("reef", {"dives:read", "dives:write", "jobs:write"});
    const std::string job_id = server.make_job("reef", "report.html", "<p>Reef</p>");
    const std::string job = "/api/v1/jobs/" + job_id;
    const std::string dive =
        "/api/v1/dives/" + get(job, writer).json()["dive_id"].get<std::string>();
    const std::string other_job = "/api/v1/jobs/" + server.make_job("reef", "mesh.glb", "glTF");
};

TEST_F(ShareTest, ItsSecretIsShownOnceAndStoredAsItsHash) {
    const auto made = share({{"name", "reviewers"}, {"expires_in_s", 3600}});
    const std::string secret = made["secret"];
    EXPECT_THAT(secret, testing::MatchesRegex("dms_[0-9a-f]{32}"));  // 128 bits
    EXPECT_EQ(made["url"], "/share#" + secret);
    EXPECT_EQ(made["expires_at_ms"].get<std::int64_t>() - made["created_at_ms"].get<std::int64_t>(),
              3'600'000);
    const auto list = get(job + "/shares", writer);
    EXPECT_EQ(list.body.find("dms_"), std::string::npos);
    EXPECT_EQ(list.json()["items"].at(0)["name"], "reviewers");
    const std::string folder = server.data();
    server.stop();
    const int found = std::system(("grep -rq " + secret + " " + folder).c_str());
    EXPECT_NE(found, 0) << "the secret is in the data folder";
}

TEST_F(ShareTest, ItOpensTheResultOfItsJobAndNothingElse) {
    const std::string secret = share()["secret"];
    EXPECT_EQ(get(job, secret).json()["id"], job_id);
    EXPECT_EQ(get(job + "/artifacts", secret).json()["items"].size(), 1U);
    EXPECT_EQ(get(job + "/artifacts/report.html", secret).body, "<p>Reef</p>");
    EXPECT_EQ(get(dive, secret).status, 200);
    EXPECT_EQ(get(dive + "/thumbnail.jpg", secret).status, 404) << "it has none";
    EXPECT_EQ(server.request("HEAD", job + "/artifacts/report.html", secret).status, 200);
    for (const auto& path : {other_job,
                             other_job + "/artifacts/mesh.glb",
                             job + "/log",
                             dive + "x",
                             job + "/shares",
                             std::string("/api/v1/jobs"),
                             std::string("/api/v1/dives"),
                             std::string("/api/v1/events"),
                             job + "/artifacts/../../x/artifacts/mesh.glb"})
        EXPECT_NE(get(path, secret).status / 100, 2) << path;
    EXPECT_EQ(server.post_json(job + "/shares", secret, nlohmann::json::object()).status, 403);
}

// Checks every route, future ones too.
TEST_F(ShareTest, EveryOtherRouteIsForbidden) {
    const std::string secret = share()["secret"];
    int num_open = 0;
    for (const api::Route& route : api::routes()) {
        if (route.scope.empty() || route.scope == api::kAnyToken)
            continue;  // session_test has these
        std::string path(route.path);
        const auto fill = [&path](const std::string& name, const std::string& id) {
            if (const auto at = path.find(name); at != std::string::npos)
                path.replace(at, name.size(), id);
        };
        fill("{job_id}", job_id);
        fill("{dive_id}", dive.substr(dive.rfind('/') + 1));
        fill("{artifact_name...}", "report.html");
        const auto answer =
            server.request(std::string(api::http::to_string(route.method)),
                           path,
                           secret,
                           {{"Tus-Resumable", "1.0.0"}, {"Content-Type", "application/json"}},
                           "{}");
        if (answer.status != 403) ++num_open;
    }
    EXPECT_EQ(num_open, 6) << "job, artifacts, artifact, archive, dive, thumbnail";
}

TEST_F(ShareTest, ItEndsAtOnceWhenItIsWithdrawn) {
    const auto made = share();
    const std::string kept = share()["secret"];
    EXPECT_EQ(get(job, made["secret"]).status, 200);
    EXPECT_EQ(withdraw(made["id"]), 204);
    EXPECT_EQ(get(job, made["secret"]).status, 401);
    EXPECT_EQ(get(job, kept).status, 200);
    EXPECT_EQ(withdraw("share_none"), 404);
    const auto items = get(job + "/shares", writer).json()["items"];
    EXPECT_EQ(items.at(0)["withdrawn"], true);
    EXPECT_GT(items.at(0)["last_used_at_ms"], 0);
    EXPECT_EQ(items.at(1)["withdrawn"], false);
}

TEST_F(ShareTest, ItOpensNothingOnceItHasExpired) {
    const std::string secret = share()["secret"];
    let_links_expire();
    EXPECT_EQ(get(job, secret).status, 401);
}

TEST_F(ShareTest, ItOpensNothingWhileItsResultOrDiveIsDeleted) {
    const std::string secret = share()["secret"];
    for (const std::string& deleted : {job, dive}) {
        EXPECT_EQ(server.request("DELETE", deleted, writer, {{"If-Match", "*"}}).status / 100, 2);
        EXPECT_EQ(get(job, secret).status, 401) << deleted;
        EXPECT_EQ(server.post_json(job + "/shares", writer, nlohmann::json::object()).status, 409)
            << deleted;
        EXPECT_EQ(server.post_json(deleted + "/restore", writer, nlohmann::json::object()).status,
                  200);
        EXPECT_EQ(get(job, secret).status, 200) << deleted;
    }
}

TEST_F(ShareTest, AVisitIsAuditedOnceWithItsAddressAndWithoutTheSecret) {
    const auto made = share({{"name", "reviewers"}});
    const std::string secret = made["secret"];
    get(other_job, secret);
    EXPECT_TRUE(visits().empty()) << "it was refused";
    get(job, secret);
    get(job + "/artifacts/report.html", secret);
    ASSERT_EQ(visits().size(), 1U);
    const Event visit = visits()[0];
    EXPECT_EQ(visit.topic, "audit");
    EXPECT_EQ(visit.project, "") << "only administrators see it";
    EXPECT_EQ(visit.data["token"], made["id"]);
    EXPECT_EQ(visit.data["token_name"], "reviewers");
    EXPECT_EQ(visit.data["peer"], "127.0.0.1");
    EXPECT_EQ(visit.data["path"], job);
    EXPECT_EQ(visit.data.dump().find(secret.substr(4)), std::string::npos);
}

TEST_F(ShareTest, WhatMakesNoSenseIsRefused) {
    const auto status = [&](const nlohmann::json& body) {
        return server.post_json(job + "/shares", writer, body).status;
    };
    EXPECT_EQ(status({{"expires_in_s", 0}}), 400);
    EXPECT_EQ(status({{"expires_in_s", 366 * 86'400 + 1}}), 400);
    EXPECT_EQ(status({{"expires_in_s", "a week"}}), 400);
    EXPECT_EQ(status({{"name", std::string(101, 'x')}}), 400);
    EXPECT_EQ(status({{"path", "/"}}), 400);
    EXPECT_EQ(
        server.post_json("/api/v1/jobs/job_none/shares", writer, nlohmann::json::object()).status,
        404);
    const std::string queued =
        server.post_json(dive + "/jobs", writer, {{"preset", "fast"}}).header("location");
    const auto refused = server.post_json(queued + "/shares", writer, nlohmann::json::object());
    EXPECT_EQ(refused.status, 409);
    EXPECT_NE(refused.body.find("no result to share"), std::string::npos) << refused.body;
}

TEST_F(ShareTest, AJobHasAHundredValidLinksAtMost) {
    storage::ShareStore shares(server.catalog());
    for (int i = 0; i < 100; ++i) shares.create(job_id, {});
    EXPECT_EQ(server.post_json(job + "/shares", writer, nlohmann::json::object()).status, 409);
    let_links_expire();
    EXPECT_EQ(server.post_json(job + "/shares", writer, nlohmann::json::object()).status, 201);
}

TEST_F(ShareTest, AReportIsShownAsAPageInWhichNothingRuns) {
    const auto report = get(job + "/artifacts/report.html", writer);
    EXPECT_EQ(report.header("content-type"), "text/html; charset=utf-8");
    EXPECT_TRUE(report.header("content-disposition").starts_with("inline"));
    EXPECT_EQ(report.header("content-security-policy"),
              "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:");
    EXPECT_EQ(report.header("x-content-type-options"), "nosniff");
    const std::string drawing =
        "/api/v1/jobs/" + server.make_job("reef", "drawing.html", "<script>") + "/artifacts/";
    const auto page = get(drawing + "drawing.html", writer);
    EXPECT_TRUE(page.header("content-disposition").starts_with("attachment"));
    EXPECT_EQ(page.header("content-security-policy"), "sandbox; default-src 'none'");
}

}  // namespace
}  // namespace divemesh
