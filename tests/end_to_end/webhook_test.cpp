#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "api/client/rest_client.hpp"
#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// S32: foreign code finds our signatures good.
TEST(WebhookTest, A12MessagesPassTheLibraryOfStandardWebhooks) {
    const fs::path scripts = source_directory() / "tests/end_to_end/js";
    if (!fs::exists(scripts / "node_modules/standardwebhooks"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    setenv("DIVEMESH_WEBHOOK_NETWORK", "127.0.0.1", 1);
    Service service;
    service.start_server(0);
    unsetenv("DIVEMESH_WEBHOOK_NETWORK");
    const fs::path secret_file = service / "secret";
    Process node(
        {"/usr/bin/env", "node", (scripts / "webhook_receiver.mjs").string(), secret_file.string()},
        service / ".");
    ASSERT_TRUE(wait_until(30s, [&] { return node.stdout_text().ends_with('\n'); }))
        << node.stderr_text();
    const std::string receiver = node.stdout_text().substr(0, node.stdout_text().find('\n'));

    api::client::RestClient client(
        {api::client::parse_server_url(service.address()), service.token()});
    const auto webhook =
        client.post("/api/v1/webhooks", {{"url", receiver}, {"topics", {"upload", "dive"}}});
    std::ofstream(secret_file) << webhook.at("secret").get<std::string>();
    const Outcome upload = service.run({"upload", small_dive().string(), "--no-job"}, 60s);
    ASSERT_EQ(upload.exit_code, 0) << upload.err;

    EXPECT_TRUE(wait_until(30s, [&] {
        return node.stdout_text().find("good dive.created") != std::string::npos;
    })) << node.stdout_text();
    EXPECT_NE(node.stdout_text().find("good upload.completed"), std::string::npos);
    EXPECT_EQ(node.stdout_text().find("bad"), std::string::npos) << node.stdout_text();
}

}  // namespace
}  // namespace divemesh
