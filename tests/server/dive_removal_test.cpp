#include <gtest/gtest.h>

#include "schemas/content_hash.hpp"
#include "storage/job_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

class DiveRemovalTest : public testing::Test {
protected:
    RawResponse get(const std::string& target) {
        return server.request("GET", target, server.admin());
    }
    RawResponse remove(const std::string& etag) {
        return server.request("DELETE", dive, server.admin(), {{"If-Match", etag}});
    }
    RawResponse restore() { return server.request("POST", dive + "/restore", server.admin()); }
    std::size_t num_dives(const std::string& query) {
        return get("/api/v1/dives" + query).json()["items"].size();
    }

    TestServer server;
    const std::string id = server.make_dive("default", sha256_hex("1"));
    const std::string dive = "/api/v1/dives/" + id;
};

TEST_F(DiveRemovalTest, NeedsToKnowWhatItDeletes) {
    const std::string etag = get(dive).header("etag");
    EXPECT_EQ(server.request("DELETE", dive, server.admin()).status, 428);
    EXPECT_EQ(remove("\"other\"").status, 412);
    EXPECT_EQ(remove("W/" + etag).status, 412);
    EXPECT_EQ(num_dives(""), 1U);
    EXPECT_EQ(remove("\"other\", " + etag).status, 200);
    EXPECT_EQ(remove(etag).status, 412);
    EXPECT_EQ(remove("*").status, 200);
}

TEST_F(DiveRemovalTest, ADeletedDiveSaysWhenItExpiresAndCanBeBroughtBack) {
    const auto deleted = remove("*").json();
    EXPECT_GT(deleted["deleted_at_ms"], 0);
    EXPECT_GT(deleted["expires_at_ms"], deleted["deleted_at_ms"]);
    EXPECT_EQ(num_dives(""), 0U);
    EXPECT_EQ(num_dives("?deleted=true"), 1U);
    EXPECT_EQ(restore().json()["expires_at_ms"], 0);
    EXPECT_EQ(num_dives(""), 1U);
    EXPECT_EQ(num_dives("?deleted=true"), 0U);
}

TEST_F(DiveRemovalTest, ItsJobsAreCancelledAndNewOnesAreRefused) {
    const auto job = server.post_json(dive + "/jobs", server.admin(), {{"preset", "paper"}});
    const std::string path = job.header("location");
    remove("*");
    EXPECT_EQ(get(path).json()["state"], "cancelled");
    EXPECT_EQ(server.post_json(dive + "/jobs", server.admin(), {{"preset", "paper"}}).status, 409);
    EXPECT_EQ(server.request("POST", path + "/retry", server.admin()).status, 409);
    restore();
    EXPECT_EQ(server.request("POST", path + "/retry", server.admin()).status, 200);
}

TEST_F(DiveRemovalTest, ADeletedDiveIsNotRestoredBesideItsTwin) {
    remove("*");
    const std::string twin = server.make_dive("default", sha256_hex("1"));
    EXPECT_NE(twin, id);
    EXPECT_EQ(restore().status, 409);
}

TEST(DivesTest, AreFoundByTagSiteAndTime) {
    TestServer server;
    const auto find = [&](const std::string& query) {
        return server.request("GET", "/api/v1/dives?" + query, server.admin());
    };
    const std::string id =
        server.make_dive("default", sha256_hex("1"), {.site = "bay", .tags = {"reef", "a_b%"}});
    server.make_dive("default", sha256_hex("2"));
    for (const char* query : {"tag=reef", "tag=a_b%25", "site=bay", "tag=reef&site=bay"}) {
        const auto items = find(query).json()["items"];
        ASSERT_EQ(items.size(), 1U) << query;
        EXPECT_EQ(items[0]["id"], id);
    }
    // Wildcards of SQL are plain characters here.
    for (const char* query : {"tag=re%25f", "tag=%25", "tag=_____", "site=%25", "tag=REEF"})
        EXPECT_EQ(find(query).json()["items"].size(), 0U) << query;
    const std::int64_t created = find("tag=reef").json()["items"][0]["created_at_ms"];
    const auto around = [&](std::int64_t after, std::int64_t before) {
        return find("tag=reef&created_after_ms=" + std::to_string(after) +
                    "&created_before_ms=" + std::to_string(before))
            .json()["items"]
            .size();
    };
    EXPECT_EQ(around(created - 1, created + 1), 1U);
    EXPECT_EQ(around(created, created + 1), 0U);
    EXPECT_EQ(around(created - 1, created), 0U);
    for (const char* query : {"created_after_ms=x",
                              "created_before_ms=-1",
                              "created_after_ms=99999999999999999999",
                              "deleted=yes"})
        EXPECT_EQ(find(query).status, 400) << query;
}

}  // namespace
}  // namespace divemesh
