#include <fstream>
#include <gmock/gmock.h>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "schemas/content_hash.hpp"
#include "storage/job_store.hpp"
#include "tests/paths.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

// Prometheus' text format 0.0.4: every line of it, or the test fails.
std::map<std::string, double> parse(const std::string& text) {
    static const std::regex comment(R"(# (HELP|TYPE) [a-z_]+ .+)");
    static const std::regex sample(
        R"(([a-z_]+(\{[a-z]+="[^"\\]*"(,[a-z]+="[^"\\]*")*\})?) ([0-9.e+-]+|NaN))");
    std::map<std::string, double> values;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::smatch parts;
        if (std::regex_match(line, parts, sample))
            EXPECT_TRUE(values.emplace(parts[1], std::stod(parts[4])).second) << line;
        else
            EXPECT_TRUE(std::regex_match(line, comment)) << line;
    }
    return values;
}

TEST(MetricsTest, CountWhatHappened) {
    TestServer server;
    const std::string token = server.make_token("default", {"metrics:read"});
    server.make_job("default", "mesh.glb", "glTF");
    for (int i = 0; i < 3; ++i) server.request("GET", "/api/v1/dives", server.admin());
    server.request("GET", "/api/v1/dives", "dm_wrong");
    server.request("GET", "/nothing", "");
    create_upload(server.port(), server.admin(), 10);

    const auto response = server.request("GET", "/metrics", token);
    EXPECT_TRUE(response.header("content-type").starts_with("text/plain; version=0.0.4"));
    auto values = parse(response.body);
    const std::string dives = R"(method="GET",route="/api/v1/dives")";
    EXPECT_EQ(values["divemesh_http_requests_total{" + dives + R"(,status="2xx"})"], 3);
    EXPECT_EQ(values["divemesh_http_requests_total{" + dives + R"(,status="4xx"})"], 1);
    EXPECT_EQ(values[R"(divemesh_http_requests_total{method="",route="",status="4xx"})"], 1);
    EXPECT_EQ(values["divemesh_http_request_seconds_count{" + dives + "}"], 4);
    EXPECT_EQ(values["divemesh_http_request_seconds_bucket{" + dives + R"(,le="+Inf"})"], 4);
    EXPECT_EQ(values[R"(divemesh_jobs{state="succeeded"})"], 2);
    EXPECT_EQ(values["divemesh_uploads_open"], 1);
    EXPECT_EQ(values["divemesh_artifact_bytes"], 4);
    EXPECT_GT(values["divemesh_disk_free_bytes"], 0);
    EXPECT_GE(values["divemesh_connections"], 1);
}

TEST(MetricsTest, AnUploadThatEndedOrIsWholeIsNotOpen) {
    TestServer server;
    const auto& token = server.admin();
    const auto send = [&](std::int64_t length) {
        const auto path = create_upload(server.port(), token, length);
        RawClient(server.port()).request("PATCH", path, patch_headers(token, 0), "12345");
        return path;
    };
    const auto terminated = send(10);
    send(5);
    send(20);
    EXPECT_EQ(RawClient(server.port()).request("DELETE", terminated, tus_headers(token)).status,
              204);

    auto values = parse(server.request("GET", "/metrics", token).body);
    EXPECT_EQ(values["divemesh_uploads_open"], 1);
    EXPECT_EQ(values["divemesh_uploads_open_bytes"], 5);
}

TEST(MetricsTest, TellHowLargeUploadsAreAndHowMuchNeedNotComeAgain) {
    TestServer server;
    const auto& token = server.admin();
    const auto path = create_upload(server.port(), token, 20'000);
    upload_offset(server.port(), token, path);  // nothing there: nothing resumed
    const auto patch = [&](std::int64_t offset, std::size_t size) {
        return RawClient(server.port())
            .request("PATCH", path, patch_headers(token, offset), std::string(size, 'x'))
            .status;
    };
    EXPECT_EQ(patch(0, 15'000), 204);
    upload_offset(server.port(), token, path);
    EXPECT_EQ(patch(15'000, 5'000), 204);
    upload_offset(server.port(), token, path);  // whole: nothing is missing

    auto values = parse(server.request("GET", "/metrics", token).body);
    EXPECT_EQ(values["divemesh_upload_resumed_bytes_count"], 1);
    EXPECT_EQ(values["divemesh_upload_resumed_bytes_sum"], 15'000);
    EXPECT_EQ(values["divemesh_upload_bytes_count"], 1);
    EXPECT_EQ(values["divemesh_upload_bytes_sum"], 20'000);
    EXPECT_EQ(values[R"(divemesh_upload_bytes_bucket{le="10000"})"], 0);
    EXPECT_EQ(values[R"(divemesh_upload_bytes_bucket{le="1e+06"})"], 1);
}

TEST(MetricsTest, TellHowLongTheStagesOfAllJobsTook) {
    TestServer server;
    storage::JobStore jobs(server.catalog());
    const auto dive = server.make_dive("default", sha256_hex("1"));
    jobs.enqueue({.dive_id = dive, .preset = "fast"});
    const auto lease = jobs.claim("boat:1", std::chrono::minutes(1))->lease;
    jobs.report_stage(lease, {.name = "track", .seconds = 0.1});
    jobs.report_stage(lease, {.name = "track", .seconds = 40.0});
    jobs.report_stage(lease, {.name = "track", .seconds = 0.01, .from_cache = true});
    jobs.report_stage(lease, {.name = "fuse", .seconds = 1e6});
    jobs.report_stage(lease, {.name = "x\"} 1\nevil{y=\"", .seconds = 1.0});

    auto values = parse(server.request("GET", "/metrics", server.admin()).body);
    const auto track = [&](const std::string& bound) {
        return values["divemesh_stage_seconds_bucket{stage=\"track\",le=\"" + bound + "\"}"];
    };
    EXPECT_EQ(track("0.1"), 1);
    EXPECT_EQ(track("30"), 1);
    EXPECT_EQ(track("60"), 2);
    EXPECT_EQ(track("+Inf"), 2);
    EXPECT_DOUBLE_EQ(values[R"(divemesh_stage_seconds_sum{stage="track"})"], 40.1);
    EXPECT_EQ(values[R"(divemesh_stage_seconds_count{stage="track"})"], 2);
    EXPECT_EQ(values[R"(divemesh_stages_cached_total{stage="track"})"], 1);
    EXPECT_EQ(values[R"(divemesh_stage_seconds_bucket{stage="fuse",le="14400"})"], 0);
    EXPECT_EQ(values[R"(divemesh_stage_seconds_count{stage="fuse"})"], 1);
}

// Checks that the server exports every metric of the dashboard.
TEST(MetricsTest, EveryMetricOfTheDashboardExists) {
    TestServer server;
    const auto text = server.request("GET", "/metrics", server.admin()).body;
    std::ifstream file(source_directory() / "deploy/grafana/divemesh.json");
    const auto dashboard = nlohmann::json::parse(file);
    static const std::regex name("divemesh_[a-z_]+");
    std::set<std::string> shown;
    for (const auto& panel : dashboard["panels"])
        for (const auto& target : panel.value("targets", nlohmann::json::array())) {
            const auto expression = target["expr"].get<std::string>();
            for (std::sregex_iterator found(expression.begin(), expression.end(), name), end;
                 found != end;
                 ++found)
                shown.insert(found->str());
        }
    for (const auto& series : shown) {
        const auto family = std::regex_replace(series, std::regex("_(bucket|count|sum)$"), "");
        EXPECT_NE(text.find("# TYPE " + family + " "), std::string::npos) << series;
    }
    for (const char* series : {"divemesh_http_request_seconds_bucket",
                               "divemesh_upload_bytes_bucket",
                               "divemesh_uploads_open",
                               "divemesh_upload_resumed_bytes_count",
                               "divemesh_lease_oldest_seconds",
                               "divemesh_jobs",
                               "divemesh_attempts",
                               "divemesh_stage_seconds_bucket",
                               "divemesh_event_streams_dropped_total",
                               "divemesh_disk_free_bytes",
                               "divemesh_sensor_streams",
                               "divemesh_sensor_messages_total",
                               "divemesh_sensor_frames_refused_total"})
        EXPECT_TRUE(shown.contains(series)) << series;
}

TEST(MetricsTest, AreForWhoMayReadThem) {
    TestServer server;
    EXPECT_EQ(server.request("GET", "/metrics", "").status, 401);
    const std::string reader = server.make_token("default", {"dives:read"});
    EXPECT_EQ(server.request("GET", "/metrics", reader).status, 403);
}

}  // namespace
}  // namespace divemesh
