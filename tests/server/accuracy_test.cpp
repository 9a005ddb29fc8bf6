// Truth that comes later, reports and comparisons, metrics as series, schedules: over HTTP.
#include <gtest/gtest.h>

#include "schemas/content_hash.hpp"
#include "storage/job_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

class AccuracyTest : public TusTest {
protected:
    RawResponse get(const std::string& target, const std::string& by = "") {
        return server.request("GET", target, by.empty() ? server.admin() : by);
    }
    RawResponse post(const std::string& target, const json& body) {
        return server.post_json(target, server.admin(), body);
    }
    std::string metadata(const std::string& kind, const std::string& name) const {
        return "truth " + base64(kind) + ",dive_id " + base64(id) + ",filename " + base64(name);
    }
    RawResponse send(const std::string& content,
                     const std::string& kind = "ground_truth",
                     const std::string& name = "tracker.tum") {
        const auto size = static_cast<std::int64_t>(content.size());
        return patch(create_upload(server.port(), token, size, metadata(kind, name)), 0, content);
    }
    RawResponse report(const json& options = json::object()) {
        return post(dive + "/jobs", {{"kind", "accuracy_report"}, {"options", options}});
    }
    json truth() { return get(dive + "/truth").json()["items"]; }
    // The newest job that waits, by a worker.
    Job succeed(const Measurement& measured) {
        storage::JobStore jobs(server.catalog());
        const auto claim = jobs.claim("test:1", std::chrono::seconds(60));
        EXPECT_TRUE(jobs.succeed(claim->lease, {}, measured));
        return jobs.get(claim->job.id);
    }

    const std::string id = server.make_dive(
        "default", sha256_hex("1"), {.site = "bay", .rig = "aqua", .tags = {"yearly"}});
    const std::string dive = "/api/v1/dives/" + id;
};

TEST_F(AccuracyTest, TruthIsDeletedAsItWasRead) {
    const std::string file = dive + "/truth/" + send("poses").header("divemesh-truth");
    const auto deleted_if = [&](const std::string& tag) {
        return server.request("DELETE", file, server.admin(), {{"If-Match", tag}}).status;
    };
    EXPECT_EQ(deleted_if("\"other\""), 412);
    EXPECT_EQ(deleted_if(get(file).header("etag")), 204);
    EXPECT_EQ(get(file).status, 404);
}

TEST_F(AccuracyTest, TruthIsUploadedLaterAndLeavesItsDiveAsItIs) {
    const auto before = get(dive).json();
    const auto sent = send("poses");
    ASSERT_EQ(sent.status, 204) << sent.body;
    ASSERT_EQ(truth().size(), 1U);
    const json file = truth()[0];
    EXPECT_EQ(file["id"], sent.header("divemesh-truth"));
    EXPECT_EQ(file["kind"], "ground_truth");
    EXPECT_EQ(file["name"], "tracker.tum");
    EXPECT_EQ(file["sha256"], sha256_hex("poses"));
    EXPECT_EQ(file["size_bytes"], 5);
    EXPECT_EQ(get(dive).json(), before);
    EXPECT_EQ(get(dive + "/truth/" + file["id"].get<std::string>()).json(), file);
    EXPECT_EQ(send("poses").header("divemesh-truth"), file["id"]) << "the same bytes";
    EXPECT_NE(send("better").header("divemesh-truth"), file["id"]);
}

TEST_F(AccuracyTest, TruthIsFetchedAsItWasSent) {
    const auto content = dive + "/truth/" + send("poses").header("divemesh-truth") + "/content";
    const auto whole = get(content);
    EXPECT_EQ(whole.body, "poses");
    EXPECT_EQ(whole.header("etag"), '"' + sha256_hex("poses") + '"');
    EXPECT_NE(whole.header("content-disposition").find("tracker.tum"), std::string::npos);
    EXPECT_EQ(whole.header("content-type"), "application/octet-stream");
    const auto part = server.request("GET", content, token, {{"Range", "bytes=2-"}});
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.body, "ses");
    EXPECT_EQ(get(content, server.make_token("theirs", {"dives:read"})).status, 404);
    EXPECT_EQ(get(dive + "/truth/truth_none/content").status, 404);
}

TEST_F(AccuracyTest, TruthOfALinkThatBreaksGoesOnWhereItWas) {
    const auto path = create_upload(server.port(), token, 10, metadata("areas", "areas.json"));
    EXPECT_EQ(patch(path, 0, "01234").header("divemesh-truth"), "");
    EXPECT_TRUE(truth().empty());
    EXPECT_EQ(upload_offset(server.port(), token, path), 5);
    const auto last = patch(path, 5, "56789");
    EXPECT_EQ(head(path).header("divemesh-truth"), last.header("divemesh-truth"));
    EXPECT_EQ(get(path).json()["truth_id"], last.header("divemesh-truth"));
    EXPECT_EQ(post("/api/v1/dives", {{"upload_id", path.substr(path.rfind('/') + 1)}}).status, 409)
        << "it is no dive";
}

TEST_F(AccuracyTest, WhatIsNoTruthOfADiveIsRefusedBeforeAByte) {
    const auto ask = [&](const std::string& text) {
        return create({{"Upload-Length", "5"}, {"Upload-Metadata", text}}).status;
    };
    EXPECT_EQ(ask("truth " + base64("ground_truth")), 400);
    EXPECT_EQ(ask("truth " + base64("rumour") + ",dive_id " + base64(id)), 400);
    EXPECT_EQ(ask(metadata("reference", "a.ply") + ",job " + base64("fast")), 400);
    EXPECT_EQ(ask("truth " + base64("areas") + ",dive_id " + base64("dive_none")), 404);
    const auto theirs = server.make_dive("theirs", sha256_hex("2"));
    EXPECT_EQ(ask("truth " + base64("areas") + ",dive_id " + base64(theirs)), 404);
}

TEST_F(AccuracyTest, ANameIsNoPathAndOthersSeeNothing) {
    send("poses", "ground_truth", "../../etc/passwd");
    EXPECT_EQ(truth()[0]["name"], "passwd");
    const auto stranger = server.make_token("theirs", {"dives:read", "dives:write"});
    EXPECT_EQ(get(dive + "/truth", stranger).status, 404);
    const auto path = dive + "/truth/" + truth()[0]["id"].get<std::string>();
    EXPECT_EQ(server.request("DELETE", path, stranger).status, 404);
}

TEST_F(AccuracyTest, TruthCountsAndGoes) {
    const auto stored = [&] { return get("/api/v1/usage").json()["stored_bytes"].get<int>(); };
    const int before = stored();
    const auto path = dive + "/truth/" + send("poses").header("divemesh-truth");
    EXPECT_EQ(stored(), before + 5);
    const auto blobs = [&] {
        std::size_t count = 0;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(server.data()))
            count += entry.path().string().find("/truth/") != std::string::npos &&
                     entry.is_regular_file();
        return count;
    };
    EXPECT_EQ(blobs(), 1U);
    EXPECT_EQ(server.request("DELETE", path, token).status, 204);
    EXPECT_EQ(server.request("DELETE", path, token).status, 404);
    EXPECT_EQ(stored(), before);
    EXPECT_EQ(blobs(), 0U);
}

TEST_F(AccuracyTest, AReportSaysForEverWhatItIsMadeOf) {
    send("poses");
    const auto made =
        report({{"require", {"drift_percent<=0.5"}}, {"time_offset", "solve"}, {"tag", "yearly"}});
    ASSERT_EQ(made.status, 201) << made.body;
    const json job = made.json();
    EXPECT_EQ(job["kind"], "accuracy_report");
    EXPECT_EQ(job["state"], "held") << "its dive is reconstructed first";
    EXPECT_EQ(job["parents"], json({job["options"]["job"]}));
    EXPECT_EQ(job["options"]["ground_truth"], truth()[0]["id"]);
    EXPECT_EQ(job["verdict"], nullptr);
    EXPECT_EQ(report({{"ground_truth", "tracker.tum"}}).status, 201);
}

TEST_F(AccuracyTest, OptionsAreCheckedAtTheDoor) {
    const json wrong[] = {{{"voxel_m", 0.01}},
                          {{"require", "drift_percent<=0.5"}},
                          {{"require", {"drift_percent"}}},
                          {{"require", {"drft_percent<=0.5"}}},
                          {{"require", {"drift_percent<=nan"}}},
                          {{"lever_arm", "1,2"}},
                          {{"time_offset", 3}},
                          {{"tag", "monthly"}},
                          {{"fresh", "yes"}},
                          {{"with", id}}};
    for (const json& options : wrong) {
        const auto refused = report(options);
        EXPECT_EQ(refused.status, 400) << options << refused.body;
    }
    EXPECT_EQ(report({{"drift", 1}}).json()["errors"][0]["pointer"], "/options/drift");
    EXPECT_EQ(report({{"reference", "none.ply"}}).status, 404);
    EXPECT_EQ(report({{"job", "job_none"}}).status, 404);
    EXPECT_EQ(post(dive + "/jobs", {{"kind", "compare"}}).status, 400);
    EXPECT_EQ(post(dive + "/jobs", {{"kind", "intake"}}).status, 400);
}

TEST_F(AccuracyTest, AVerdictIsNoFailure) {
    report({{"require", {"path_length_m>=3", "path_length_m>=1"}}});
    succeed({.metrics = {{"trajectory.path_length_m", 2.0, "m", ""}}, .version = "1"});
    const Job job = succeed(
        {.metrics = {{"trajectory.path_length_m", 2.0, "m", ""}},
         .requirements = {{"path_length_m>=3", "trajectory.path_length_m", 2.0, false, "is 2"},
                          {"path_length_m>=1", "trajectory.path_length_m", 2.0, true, ""}},
         .version = "1"});
    const json shown = get("/api/v1/jobs/" + job.id).json();
    EXPECT_EQ(shown["state"], "succeeded");
    EXPECT_EQ(shown["verdict"], "failed");
    EXPECT_EQ(shown["requirements"].size(), 2U);
}

TEST_F(AccuracyTest, MetricsAreSeriesOverDivesAndTime) {
    report();
    for (const double length_m : {2.0, 2.5})
        succeed({.metrics = {{"trajectory.path_length_m", length_m, "m", "sum"}},
                 .version = "1",
                 .calibration_sha256 = "c"});
    const auto series = [&](const std::string& query) {
        const auto answer = get("/api/v1/metrics?metric=trajectory.path_length_m" + query);
        EXPECT_EQ(answer.status, 200) << answer.body;
        return answer.json();
    };
    const json all = series("");
    EXPECT_EQ(all["metric"], "trajectory.path_length_m");
    EXPECT_EQ(all["unit"], "m");
    ASSERT_EQ(all["items"].size(), 2U);
    EXPECT_EQ(all["items"][0]["value"], 2.0);
    EXPECT_EQ(all["items"][1]["kind"], "accuracy_report");
    EXPECT_EQ(all["items"][0]["rig"], "aqua");
    for (const char* query : {"&site=bay", "&rig=aqua", "&tag=yearly", "&since=0"})
        EXPECT_EQ(series(query)["items"].size(), 2U) << query;
    for (const char* query : {"&site=b_y", "&rig=%25", "&tag=", "&since=99999999999999"})
        EXPECT_EQ(series(query)["items"].size(), std::string(query) == "&tag=" ? 2U : 0U) << query;
    EXPECT_EQ(series("&kind=reconstruct")["items"].size(), 1U);
    const json page = series("&limit=1");
    EXPECT_EQ(
        series("&limit=1&cursor=" + page["next_cursor"].get<std::string>())["items"][0]["value"],
        2.5);
    EXPECT_EQ(get("/api/v1/metrics").status, 400);
    EXPECT_EQ(get("/api/v1/metrics?metric=beauty").status, 400);
    const auto stranger = server.make_token("theirs", {"dives:read"});
    EXPECT_TRUE(get("/api/v1/metrics?metric=path_length_m", stranger).json()["items"].empty());
}

TEST_F(AccuracyTest, ASchedulesOptionsAndTimesAreChecked) {
    const json good = {{"cron", "30 4 1 * *"},
                       {"tag", "yearly"},
                       {"options", {{"require", {"drift_percent<=0.5"}}}}};
    const auto made = post("/api/v1/schedules", good);
    ASSERT_EQ(made.status, 201) << made.body;
    EXPECT_EQ(get(made.header("location")).json(), made.json());
    EXPECT_EQ(get("/api/v1/schedules").json()["items"].size(), 1U);
    for (const auto& [key, value] : {std::pair{"cron", json("30 4 31 2 *")},
                                     std::pair{"cron", json("often")},
                                     std::pair{"tag", json("")},
                                     std::pair{"preset", json("best")},
                                     std::pair{"options", json({{"job", "job_1"}})},
                                     std::pair{"until", json(5)}}) {
        json bad = good;
        bad[key] = value;
        EXPECT_EQ(post("/api/v1/schedules", bad).status, 400) << key << value;
    }
    const auto stranger = server.make_token("theirs", {"dives:read", "jobs:write"});
    EXPECT_EQ(get(made.header("location"), stranger).status, 404);
    EXPECT_EQ(server.request("DELETE", made.header("location"), stranger).status, 404);
    EXPECT_EQ(server.request("DELETE", made.header("location"), server.admin()).status, 204);
    EXPECT_TRUE(get("/api/v1/schedules").json()["items"].empty());
}

}  // namespace
}  // namespace divemesh
