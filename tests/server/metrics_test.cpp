#include <gmock/gmock.h>
#include <map>
#include <regex>
#include <sstream>

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

// S26
TEST(MetricsTest, S26AreForWhoMayReadThem) {
    TestServer server;
    EXPECT_EQ(server.request("GET", "/metrics", "").status, 401);
    const std::string reader = server.make_token("default", {"dives:read"});
    EXPECT_EQ(server.request("GET", "/metrics", reader).status, 403);
}

}  // namespace
}  // namespace divemesh
