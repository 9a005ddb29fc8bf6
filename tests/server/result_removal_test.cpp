// Results over HTTP: they count towards the quota, can be deleted and restored.
#include <gtest/gtest.h>

#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

server::ServerConfig with_quota(std::int64_t max_bytes) {
    server::ServerConfig config;
    config.max_project_bytes = max_bytes;
    return config;
}

class ResultRemovalTest : public testing::Test {
protected:
    RawResponse get(const std::string& target) { return server.request("GET", target, token); }

    TestServer server{with_quota(1000)};
    const std::string token =
        server.make_token("default", {"dives:read", "dives:write", "jobs:write"});
};

TEST_F(ResultRemovalTest, AResultIsDeletedAndRestored) {
    const std::string job = "/api/v1/jobs/" + server.make_job("default", "mesh.glb", "glTF");
    EXPECT_FALSE(get(job).json().contains("deleted_at_ms"));

    const auto deleted = server.request("DELETE", job, token);
    EXPECT_EQ(deleted.status, 200) << deleted.body;
    EXPECT_GT(deleted.json()["expires_at_ms"], deleted.json()["deleted_at_ms"]);
    EXPECT_EQ(get(job + "/artifacts").status, 410);
    EXPECT_EQ(get(job + "/artifacts/mesh.glb").status, 410);
    EXPECT_EQ(get(job).status, 200);
    EXPECT_EQ(get("/api/v1/jobs?kind=reconstruct").json()["items"].size(), 0U);
    EXPECT_EQ(get("/api/v1/jobs?deleted=true").json()["items"].size(), 1U);
    EXPECT_EQ(server.request("DELETE", job, token, {{"If-Match", "\"x\""}}).status, 412);

    EXPECT_EQ(server.request("POST", job + "/restore", token).status, 200);
    EXPECT_EQ(get(job + "/artifacts/mesh.glb").body, "glTF");
    const auto reader = server.make_token("default", {"dives:read"});
    EXPECT_EQ(server.request("DELETE", job, reader).status, 403);
}

TEST_F(ResultRemovalTest, OnlyAnAdministratorRemovesItAtOnce) {
    const std::string job = "/api/v1/jobs/" + server.make_job("default", "mesh.glb", "glTF");
    EXPECT_EQ(server.request("DELETE", job + "?purge=true", token).status, 403);
    EXPECT_EQ(server.request("DELETE", job + "?purge=true", server.admin()).status, 200);
    EXPECT_EQ(get("/api/v1/usage").json()["stored_bytes"], 0);
    EXPECT_EQ(server.request("POST", job + "/restore", token).status, 409);
    EXPECT_EQ(get(job).json()["state"], "succeeded");
}

TEST_F(ResultRemovalTest, ResultsUseUpTheQuota) {
    const std::string id = server.make_job("default", "mesh.glb", std::string(1500, 'x'));
    const std::string job = "/api/v1/jobs/" + id;
    const std::string jobs_of_dive =
        "/api/v1/dives/" + get(job).json()["dive_id"].get<std::string>() + "/jobs";
    EXPECT_EQ(get("/api/v1/usage").json()["stored_bytes"], 1500);
    const auto upload = [&] {
        return server.request(
            "POST", "/api/v1/uploads", "", tus_headers(token, {{"Upload-Length", "1"}}));
    };
    const auto ask = [&] { return server.post_json(jobs_of_dive, token, {{"preset", "fast"}}); };

    EXPECT_EQ(upload().status, 403);
    EXPECT_EQ(ask().status, 403);
    EXPECT_NE(ask().json()["detail"].get<std::string>().find("results"), std::string::npos);
    EXPECT_EQ(server.request("DELETE", job + "?purge=true", server.admin()).status, 200);
    EXPECT_EQ(upload().status, 201);
    EXPECT_EQ(ask().status, 201);
}

TEST_F(ResultRemovalTest, AProjectKeepsAsManyAsItWants) {
    const auto changed = server.request("PATCH",
                                        "/api/v1/queue",
                                        server.admin(),
                                        {{"Content-Type", "application/json"}},
                                        R"({"project": "default", "keep_results": 2})");
    EXPECT_EQ(changed.status, 200) << changed.body;
    EXPECT_EQ(get("/api/v1/queue").json()["keep_results"], 2);
}

}  // namespace
}  // namespace divemesh
