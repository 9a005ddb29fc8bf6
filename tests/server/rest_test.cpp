#include <gtest/gtest.h>

#include <set>

#include "schemas/content_hash.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

class RestTest : public testing::Test {
protected:
    int post(const std::string& target, const nlohmann::json& body) {
        return server.post_json(target, token, body).status;
    }
    RawResponse get(const std::string& target) { return server.request("GET", target, token); }

    TestServer server;
    const std::string token = server.admin();
};

TEST_F(RestTest, PagesThroughAListByItsLinks) {
    for (int i = 0; i < 5; ++i) server.make_dive("default", sha256_hex(std::to_string(i)));
    std::vector<std::string> seen;
    std::string target = "/api/v1/dives?limit=2&state=ready";
    while (!target.empty()) {
        const auto page = get(target);
        ASSERT_EQ(page.status, 200) << page.body;
        const auto body = page.json();
        for (const auto& dive : body["items"]) seen.push_back(dive["archive_sha256"]);
        const std::string link = page.header("link");
        EXPECT_EQ(link.empty(), body["next_cursor"] == "");
        target = link.empty() ? "" : link.substr(1, link.find('>') - 1);
    }
    ASSERT_EQ(seen.size(), 5U);
    for (int i = 0; i < 5; ++i)
        EXPECT_EQ(seen[static_cast<std::size_t>(i)], sha256_hex(std::to_string(i)));
}

TEST_F(RestTest, FindsADiveByItsHash) {
    const auto id = server.make_dive("default", std::string(64, 'a'));
    const auto found = get("/api/v1/dives?archive_sha256=" + std::string(64, 'a')).json()["items"];
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0]["id"], id);
    EXPECT_EQ(get("/api/v1/dives?archive_sha256=" + std::string(64, 'b')).json()["items"].size(),
              0U);
}

TEST_F(RestTest, RefusesListsThatMakeNoSense) {
    for (const char* query : {"limit=0",
                              "limit=201",
                              "limit=x",
                              "limit=-1",
                              "cursor=forged",
                              "cursor=%27%20OR%201=1",
                              "state=none",
                              "content_sha256=abc",
                              "limit=1&limit=2"})
        EXPECT_EQ(get("/api/v1/dives?" + std::string(query)).status, 400) << query;
    EXPECT_EQ(get("/api/v1/jobs?state=none").status, 400);
    EXPECT_EQ(get("/api/v1/jobs?kind=none").status, 400);
}

TEST_F(RestTest, ShortListsArePagedToo) {
    for (int i = 0; i < 4; ++i) server.make_token("default", {"dives:read"});
    const std::string list = "/api/v1/tokens";
    const auto all = get(list).json()["items"];
    nlohmann::json paged = nlohmann::json::array();
    std::string next = list + "?limit=2";
    for (int pages = 0; !next.empty() && pages < 10; ++pages) {
        const auto page = get(next);
        const auto items = page.json()["items"];
        for (const auto& item : items) paged.push_back(item);
        EXPECT_LE(items.size(), 2U);
        const std::string link = page.header("link");
        next = link.empty() ? "" : link.substr(1, link.find('>') - 1);
    }
    EXPECT_EQ(paged, all);
    for (const char* path : {"tokens", "workers", "webhooks"})
        for (const char* query : {"?limit=0", "?limit=-1", "?limit=201", "?cursor=x", "?cursor=99"})
            EXPECT_EQ(get(std::string("/api/v1/") + path + query).status, 400) << path << query;
}

TEST_F(RestTest, QueuesCancelsAndRetriesAJob) {
    const auto dive = server.make_dive("default", std::string(64, 'a'));
    const auto made = server.post_json("/api/v1/dives/" + dive + "/jobs",
                                       token,
                                       {{"preset", "paper"}, {"options", {{"num_features", 500}}}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string job = made.header("location");
    EXPECT_EQ(made.json()["state"], "queued");
    EXPECT_EQ(made.json()["options"]["num_features"], 500);
    EXPECT_EQ(server.request("POST", job + "/cancel", token).json()["state"], "cancelled");
    EXPECT_EQ(server.request("POST", job + "/cancel", token).status, 409);
    EXPECT_EQ(server.request("POST", job + "/retry", token).json()["state"], "queued");
    EXPECT_EQ(server.request("POST", job + "/retry", token).status, 409);
    EXPECT_EQ(get(job + "/artifacts").json()["items"].size(), 0U);
}

TEST_F(RestTest, RefusesJobsThatCannotBeDone) {
    const std::string jobs =
        "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a')) + "/jobs";
    EXPECT_EQ(post(jobs, {{"preset", "none"}}), 400);
    EXPECT_EQ(post(jobs, {{"options", {{"no_such_option", 1}}}}), 400);
    EXPECT_EQ(post(jobs, {{"options", {{"num_features", "many"}}}}), 400);
    EXPECT_EQ(post(jobs, {{"options", 5}}), 400);
    EXPECT_EQ(post(jobs, {{"kind", "intake"}}), 400);
    EXPECT_EQ(post(jobs, {{"priority", 1000}}), 400);
    EXPECT_EQ(post(jobs, {{"preset", 5}}), 400);
    EXPECT_EQ(post(jobs, {{"typo", 1}}), 400);
    EXPECT_EQ(post(jobs, nlohmann::json::array()), 400);
}

TEST_F(RestTest, RefusesBodiesThatAreNotTheJsonTheyShouldBe) {
    const auto send = [&](const std::string& type, std::string_view body) {
        return server.request("POST", "/api/v1/dives", token, {{"Content-Type", type}}, body)
            .status;
    };
    EXPECT_EQ(send("text/plain", "{}"), 415);
    EXPECT_EQ(send("application/xml", "{}"), 415);
    EXPECT_EQ(send("application/json", "{"), 400);
    EXPECT_EQ(send("application/json", ""), 400);
    EXPECT_EQ(send("application/json", "\xff\xfe"), 400);
    EXPECT_EQ(send("application/json", std::string(100'000, '[')), 400);
    EXPECT_EQ(send("application/json; charset=utf-8", R"({"upload_id":"none"})"), 404);
    EXPECT_EQ(send("application/json", R"({"upload_id":5})"), 400);
}

TEST_F(RestTest, TellsAllThatIsWrongAtOnceAndWhere) {
    const std::string dive = "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a'));
    const auto places = [](const RawResponse& response) {
        std::set<std::string> found;
        const auto body = response.json();
        for (const auto& error : body.at("errors")) {
            EXPECT_FALSE(error.at("detail").get<std::string>().empty());
            found.insert(error.value("pointer", "?" + error.value("parameter", "")));
        }
        return found;
    };
    const auto job = [&](const nlohmann::json& body) {
        const auto response = server.post_json(dive + "/jobs", server.admin(), body);
        EXPECT_EQ(response.status, 400) << response.body;
        return places(response);
    };
    using Places = std::set<std::string>;
    EXPECT_EQ(
        job({{"options",
              {{"voxel_m", 7.0}, {"mesher", "knife"}, {"speed", 1}, {"simplify", "no"}}}}),
        (Places{"/options/voxel_m", "/options/mesher", "/options/speed", "/options/simplify"}));
    EXPECT_EQ(job({{"colour", 1}, {"a/b", 2}}), (Places{"/colour", "/a~1b"}));
    EXPECT_EQ(job({{"options", {{"a/b", 2}}}}), Places{"/options/a~1b"});
    EXPECT_EQ(job({{"kind", "intake"}}), Places{"/kind"});
    EXPECT_EQ(job({{"kind", "dance"}}), Places{"/kind"});
    EXPECT_EQ(job({{"preset", "none"}}), Places{"/preset"});
    EXPECT_EQ(job({{"options", 5}}), Places{"/options"});
    EXPECT_EQ(job({{"priority", "high"}}), Places{"/priority"});
    EXPECT_EQ(places(get("/api/v1/dives?limit=0")), Places{"?limit"});
    EXPECT_EQ(places(get("/api/v1/dives?deleted=maybe")), Places{"?deleted"});
}

// RFC 8259, 4: with a name that occurs twice, readers differ in which value they take.
TEST_F(RestTest, RefusesKeysThatOccurTwice) {
    const std::string dive = "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a'));
    const auto place = [&](const std::string& body) {
        const auto response = server.request(
            "POST", dive + "/jobs", server.admin(), {{"Content-Type", "application/json"}}, body);
        EXPECT_EQ(response.status, 400) << body;
        return response.json()["errors"][0]["pointer"].get<std::string>();
    };
    EXPECT_EQ(place(R"({"preset": "fast", "preset": "paper"})"), "/preset");
    EXPECT_EQ(place(R"({"options": {"seed": 1, "a": [], "seed": 2}})"), "/options/seed");
    EXPECT_EQ(place(R"({"parents": [{}, [1, {"a/b": 1, "a/b": 2}]]})"), "/parents/1/1/a~1b");
    EXPECT_EQ(place(R"({"preset": "fast", "pre\u0073et": "paper"})"), "/preset");
    const auto fine = server.request("POST",
                                     dive + "/jobs",
                                     server.admin(),
                                     {{"Content-Type", "application/json"}},
                                     R"({"preset": "fast", "options": {"seed": 1}})");
    EXPECT_EQ(fine.status, 201) << fine.body;
}

TEST_F(RestTest, TellsTheLogAndTheArtifactsOfAJob) {
    const std::string job = "/api/v1/jobs/" + server.make_job("default", "mesh.glb", "glTF");
    EXPECT_EQ(get(job + "/log").body, "tracked 10 frames\n");
    const auto artifacts = get(job + "/artifacts").json()["items"];
    ASSERT_EQ(artifacts.size(), 1U);
    EXPECT_EQ(artifacts[0]["sha256"], sha256_hex("glTF"));
    EXPECT_FALSE(artifacts[0].contains("blob"));
}

TEST_F(RestTest, SendsNoResourceThatHasNotChanged) {
    const std::string dive = "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a'));
    const std::string etag = get(dive).header("etag");
    ASSERT_FALSE(etag.empty());
    EXPECT_EQ(server.request("GET", dive, token, {{"If-None-Match", etag}}).status, 304);
}

TEST_F(RestTest, AnswersHealthAndItsOwnContractToAnybody) {
    EXPECT_EQ(server.request("GET", "/healthz/live", "").json()["status"], "live");
    EXPECT_EQ(server.request("GET", "/healthz/ready", "").json()["status"], "ready");
    EXPECT_EQ(server.request("GET", "/openapi.json", "").json()["openapi"], "3.1.0");
}

TEST_F(RestTest, NamesTheMethodsOfAnAddress) {
    const auto response = server.request("PUT", "/api/v1/dives", token);
    EXPECT_EQ(response.status, 405);
    EXPECT_EQ(response.header("allow"), "GET, POST");
    EXPECT_EQ(get("/nothing").status, 404);
}

TEST_F(RestTest, RepeatsTheRequestsIdUnlessItIsHostile) {
    const auto id_of = [&](const std::string& sent) {
        return server.request("GET", "/healthz/live", "", {{"X-Request-Id", sent}})
            .header("x-request-id");
    };
    EXPECT_EQ(id_of("boat-7.1"), "boat-7.1");
    EXPECT_NE(id_of("a b\"c"), "a b\"c");
    EXPECT_EQ(id_of(std::string(100, 'x')).size(), 16U);
}

}  // namespace
}  // namespace divemesh
