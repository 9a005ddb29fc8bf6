#include <future>
#include <soci/soci.h>

#include "storage/job_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

server::ServerConfig with_quota(std::int64_t max_bytes, std::int64_t max_dives) {
    server::ServerConfig config;
    config.max_project_bytes = max_bytes;
    config.max_project_dives = max_dives;
    return config;
}

void expect_out_of_quota(const RawResponse& response) {
    EXPECT_EQ(response.status, 403) << response.body;
    EXPECT_EQ(response.json()["type"], "urn:divemesh:error:out_of_quota");
}

class ByteQuotaTest : public TusTest {
protected:
    ByteQuotaTest() : TusTest(with_quota(1000, 0)) {}
    nlohmann::json usage(const std::string& project = "default") {
        return server.request("GET", "/api/v1/usage?project=" + project, token).json();
    }
};

TEST_F(ByteQuotaTest, RefusesTheUploadThatWouldBeTooMuchAndSaysWhatThereIs) {
    create_upload(server.port(), token, 600);
    expect_out_of_quota(create({{"Upload-Length", "401"}}));
    EXPECT_EQ(create({{"Upload-Length", "400"}}).status, 201);

    EXPECT_EQ(usage(),
              nlohmann::json({{"project", "default"},
                              {"num_dives", 0},
                              {"max_dives", 0},
                              {"stored_bytes", 1000},
                              {"max_bytes", 1000}}));
}

TEST_F(ByteQuotaTest, ConcurrentUploadsDoNotExceedIt) {
    std::vector<std::future<int>> asked;
    for (int i = 0; i < 8; ++i)
        asked.push_back(std::async(std::launch::async, [this] {
            return RawClient(server.port())
                .request("POST", "/api/v1/uploads", tus_headers(token, {{"Upload-Length", "300"}}))
                .status;
        }));
    int num_made = 0;
    for (auto& status : asked) num_made += status.get() == 201 ? 1 : 0;
    EXPECT_EQ(num_made, 3);
    EXPECT_EQ(usage()["stored_bytes"], 900);
}

TEST_F(ByteQuotaTest, WhatIsTerminatedCountsNoMoreAndProjectsDoNotShare) {
    const auto path = create_upload(server.port(), token, 1000);
    const auto elsewhere = server.make_token("reef", {"dives:write", "dives:read"});
    EXPECT_EQ(
        RawClient(server.port())
            .request("POST", "/api/v1/uploads", tus_headers(elsewhere, {{"Upload-Length", "1000"}}))
            .status,
        201);
    terminate(path);
    EXPECT_EQ(usage()["stored_bytes"], 0);
    EXPECT_EQ(usage("reef")["stored_bytes"], 1000);
    EXPECT_EQ(usage("")["stored_bytes"], 1000);
    EXPECT_EQ(create({{"Upload-Length", "1000"}}).status, 201);
}

TEST_F(ByteQuotaTest, ADiveCountsAsItsUploadDid) {
    const auto path = create_upload(server.port(), token, 900, "commit");
    EXPECT_EQ(patch(path, 0, std::string(900, 'x')).status, 204);
    EXPECT_EQ(usage()["stored_bytes"], 900);
    EXPECT_EQ(usage()["num_dives"], 1);
    expect_out_of_quota(create({{"Upload-Length", "101"}}));
}

TEST_F(ByteQuotaTest, ALengthThatIsToldLaterIsHeldToIt) {
    create_upload(server.port(), token, 600);
    const auto path = create({{"Upload-Defer-Length", "1"}}).header("location");
    EXPECT_EQ(patch(path, 0, std::string(100, 'x')).status, 204);
    expect_out_of_quota(patch(path, 100, "x", {{"Upload-Length", "401"}}));
    EXPECT_EQ(patch(path, 100, std::string(300, 'x'), {{"Upload-Length", "400"}}).status, 204);
}

TEST_F(ByteQuotaTest, AStreamWithoutLengthEndsAtIt) {
    const auto path = create({{"Upload-Defer-Length", "1"}}).header("location");
    EXPECT_EQ(patch(path, 0, std::string(1000, 'x')).status, 204);
    expect_out_of_quota(patch(path, 1000, "x"));
}

// A part that is named twice counts twice.
TEST_F(ByteQuotaTest, PartsCountOnceAndTheirRepetitionsToo) {
    const auto part = make_part(std::string(400, 'x'));
    expect_out_of_quota(create({{"Upload-Concat", final_of({part, part, part})}}));
    EXPECT_EQ(create({{"Upload-Concat", final_of({part, part})}}).status, 201);
    EXPECT_EQ(usage()["stored_bytes"], 800);
}

TEST_F(ByteQuotaTest, NoDeadJobIsDrivenBeyondIt) {
    const std::string dive = server.make_dive("default", std::string(64, 'a'));
    storage::JobStore jobs(server.catalog());
    jobs.enqueue({.project = "default", .dive_id = dive, .preset = "standard", .max_attempts = 1});
    const auto claim = jobs.claim("worker", std::chrono::minutes(1));
    ASSERT_TRUE(claim);
    jobs.fail(claim->lease, {ErrorCode::Unavailable, "crashed"});
    server.catalog().transaction(
        [](soci::session& session) { session << "UPDATE dives SET archive_bytes = 1001"; });
    const auto redrive = [&] {
        return server.post_json("/api/v1/queue/redrive", token, nlohmann::json::object());
    };
    expect_out_of_quota(redrive());
    server.catalog().transaction(
        [](soci::session& session) { session << "UPDATE dives SET archive_bytes = 1"; });
    EXPECT_EQ(redrive().json()["items"][0]["waits_for"], "worker");
}

class DiveQuotaTest : public TusTest {
protected:
    DiveQuotaTest() : TusTest(with_quota(0, 1)) {}
};

TEST_F(DiveQuotaTest, RefusesTheDiveBeyondItAndKeepsItsUpload) {
    const auto first = create_upload(server.port(), token, 5, "commit");
    const auto second = create_upload(server.port(), token, 5);
    const auto made = patch(first, 0, "first");
    EXPECT_EQ(made.status, 204);
    EXPECT_EQ(patch(second, 0, "other").status, 204);
    const nlohmann::json commit = {{"upload_id", second.substr(second.rfind('/') + 1)}};

    expect_out_of_quota(server.post_json("/api/v1/dives", token, commit));
    expect_out_of_quota(create({{"Upload-Length", "5"}}));

    const auto dive = "/api/v1/dives/" + made.header("divemesh-dive");
    EXPECT_EQ(server.request("DELETE", dive, token, {{"If-Match", "*"}}).status, 200);
    EXPECT_EQ(server.post_json("/api/v1/dives", token, commit).status, 201);
    expect_out_of_quota(server.request("POST", dive + "/restore", token));
}

}  // namespace
}  // namespace divemesh
