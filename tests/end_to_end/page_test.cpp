// The web page in Chromium, from a server and a worker of its own. What is done there is in
// js/page_*.mjs.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// Where screenshots are kept: DIVEMESH_SCREENSHOTS, otherwise with the test's own files.
std::string screenshots(const Service& service) {
    const char* folder = std::getenv("DIVEMESH_SCREENSHOTS");
    return folder != nullptr ? folder : (service / "screenshots").string();
}

bool is_on_path(const std::string& program) {
    return std::system(("command -v " + program + " > /dev/null").c_str()) == 0;
}

class PageInBrowserTest : public testing::TestWithParam<std::string> {
protected:
    Service service;
};

// The script gets the server's address, an administrator's token and the folder of a small dive.
TEST_P(PageInBrowserTest, DoesWhatTheScriptAsks) {
    const fs::path scripts = source_directory() / "tests/end_to_end/js";
    if (!is_on_path("chromium")) GTEST_SKIP() << "there is no Chromium: run deploy/install.sh";
    if (!fs::exists(scripts / "node_modules/playwright-core"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    service.start_server(1);
    Process node({"/usr/bin/env",
                  "node",
                  (scripts / ("page_" + GetParam() + ".mjs")).string(),
                  service.address(),
                  service.token(),
                  small_dive().string()},
                 service / ".",
                 {{"DIVEMESH_SCREENSHOTS", screenshots(service)}});
    EXPECT_EQ(node.wait(300s), 0) << node.stdout_text() << node.stderr_text();
}

TEST(SignInTest, TheCommandLinePrintsALinkThatSignsInOnce) {
    Service service;
    service.start_server(0);
    const auto printed = service.run(
        {"token", "sign-in", "--data", (service / "data").string(), "--server", service.address()});
    ASSERT_EQ(printed.exit_code, 0) << printed.err;
    const std::string start = service.address() + "/sign-in#";
    ASSERT_TRUE(printed.out.starts_with(start)) << printed.out;
    const std::string secret =
        printed.out.substr(start.size(), printed.out.size() - start.size() - 1);
    api::client::RestClient rest({api::client::parse_server_url(service.address()), secret});
    EXPECT_EQ(rest.post("/api/v1/session", nlohmann::json::object()).at("scopes").at(0), "admin");
    EXPECT_THROW(rest.post("/api/v1/session", nlohmann::json::object()), Error);
    const auto refused =
        service.run({"token", "sign-in", "token_none", "--data", (service / "data").string()});
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find("no valid token token_none"), std::string::npos) << refused.err;
}

INSTANTIATE_TEST_SUITE_P(Scripts,
                         PageInBrowserTest,
                         testing::Values("sign_in", "security", "dive", "manners", "sensor"),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace divemesh
