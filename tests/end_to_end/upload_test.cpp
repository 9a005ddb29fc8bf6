#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>

#include "api/client/http_connection.hpp"
#include "schemas/content_hash.hpp"
#include "tests/end_to_end/service.hpp"
#include "tests/flaky_proxy.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

int port_of(const std::string& address) {
    return std::stoi(address.substr(address.rfind(':') + 1));
}

constexpr auto kSlow = "200k";  // bytes per second: the small dive takes long enough to be cut

class UploadTest : public testing::Test {
protected:
    // Uploaded so slowly that something can happen to it, and well begun.
    Process start_slow_upload() {
        Process client = service.start(
            {"upload", small_dive().string(), "--no-job", "--wait", "--limit-rate", kSlow});
        EXPECT_TRUE(wait_until(60s, [&] {
            return client.stderr_text().find("upload") != std::string::npos;
        })) << client.stderr_text();
        std::this_thread::sleep_for(2s);
        EXPECT_FALSE(client.wait(0s)) << "the upload ended too early: " << client.stderr_text();
        return client;
    }

    void expect_one_ready_dive() {
        const auto dives = service.dives();
        ASSERT_EQ(dives.size(), 1U) << dives.dump(2);
        EXPECT_EQ(dives[0].at("state"), "ready");
    }

    Service service;
};

TEST_F(UploadTest, GoesOnWhereAKilledClientStopped) {
    service.start_server(1);
    start_slow_upload().kill();
    const Outcome again =
        service.run({"upload", small_dive().string(), "--no-job", "--wait"}, 120s);
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_NE(again.err.find("resuming after"), std::string::npos) << again.err;
    expect_one_ready_dive();
}

TEST_F(UploadTest, GoesOnByItselfWhenTheServerWasKilledAndStartedAgain) {
    service.start_server(1);
    Process client = start_slow_upload();
    service.kill_server();
    service.start_server(1);
    EXPECT_EQ(client.wait(180s), 0) << client.stderr_text();
    EXPECT_NE(client.stderr_text().find("resuming after"), std::string::npos)
        << client.stderr_text();
    expect_one_ready_dive();
}

TEST_F(UploadTest, KnowsADiveWhateverItIsPackedIn) {
    service.start_server(1);
    const std::string dive = small_dive().string();
    const std::string archive = (service / "dive.tar.gz").string();
    ASSERT_EQ(std::system(("tar -C '" + dive + "' -czf '" + archive + "' .").c_str()), 0);
    const Outcome folder = service.run({"upload", dive, "--no-job", "--wait"}, 120s);
    ASSERT_EQ(folder.exit_code, 0) << folder.err;
    const Outcome packed = service.run({"upload", archive, "--no-job", "--wait"}, 120s);
    EXPECT_EQ(packed.exit_code, 0) << packed.err;
    EXPECT_NE(packed.err.find("already has this dive"), std::string::npos) << packed.err;
    EXPECT_EQ(packed.out, folder.out);
    expect_one_ready_dive();
}

TEST_F(UploadTest, ADiveThatWasDeletedIsSentAnewAndNotCalledVerified) {
    service.start_server(0);
    const Outcome first =
        service.run({"upload", small_dive().string(), "--no-job", "--json"}, 120s);
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const std::string dive = nlohmann::json::parse(first.out).at("dive");
    api::client::HttpConnection connection(api::client::parse_server_url(service.address()), 60s);
    const auto deleted =
        connection.send({"DELETE",
                         "/api/v1/dives/" + dive,
                         {{"If-Match", "*"}, {"Authorization", "Bearer " + service.token()}},
                         ""});
    ASSERT_EQ(deleted.status, 200);
    const Outcome again =
        service.run({"upload", small_dive().string(), "--no-job", "--json"}, 120s);
    ASSERT_EQ(again.exit_code, 0) << again.err;
    EXPECT_NE(nlohmann::json::parse(again.out).at("dive"), dive);
    EXPECT_EQ(nlohmann::json::parse(again.out).at("verified"), true);
    EXPECT_EQ(service.dives().size(), 1U);
}

TEST_F(UploadTest, WorksWithAStockTusClientInTwoSittings) {
    const fs::path scripts = source_directory() / "tests/end_to_end/js";
    if (!fs::exists(scripts / "node_modules/tus-js-client"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    service.start_server(1);
    const std::string archive = (service / "dive.tar").string();
    ASSERT_EQ(
        std::system(("tar -C '" + small_dive().string() + "' -cf '" + archive + "' .").c_str()), 0);
    Process node({"/usr/bin/env",
                  "node",
                  (scripts / "tus_upload.mjs").string(),
                  archive,
                  service.address() + "/api/v1/uploads"},
                 service / ".",
                 {{"DIVEMESH_TOKEN", service.token()}});
    EXPECT_EQ(node.wait(120s), 0) << node.stderr_text();
    EXPECT_TRUE(wait_until(60s, [&] { return service.dives().at(0).at("state") == "ready"; }));
    EXPECT_EQ(node.stdout_text(), service.dives().at(0).at("id").get<std::string>() + "\n");
}

TEST_F(UploadTest, ArrivesOverALinkThatFallsSilentAndSaysThatItIsVerified) {
    service.start_server(0);
    FlakyProxy proxy(port_of(service.address()),
                     {.cut = Cut::Stall, .cut_after_bytes = 300'000, .num_cuts = 3});
    const Outcome outcome = service.run({"upload",
                                         small_dive().string(),
                                         "--no-job",
                                         "--json",
                                         "--stall-timeout",
                                         "0.5",
                                         "--parallel",
                                         "2",
                                         "--server",
                                         "http://127.0.0.1:" + std::to_string(proxy.port())},
                                        120s);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(proxy.num_cuts(), 3);
    EXPECT_EQ(nlohmann::json::parse(outcome.out).at("verified"), true);
    EXPECT_EQ(service.dives().at(0).at("state"), "checking");
}

// Node from 19 on keeps a connection for all requests; Node 18 and the browser's build open one for
// each. The link is cut by its own count of bytes, so each of them is cut as often.
class TusClientTest : public UploadTest, public testing::WithParamInterface<std::string> {};
INSTANTIATE_TEST_SUITE_P(Builds,
                         TusClientTest,
                         testing::Values("node", "browser"),
                         [](const auto& build) { return build.param; });

TEST_P(TusClientTest, AStockOneArrivesOverEveryKindOfBadLink) {
    const fs::path scripts = source_directory() / "tests/end_to_end/js";
    if (!fs::exists(scripts / "node_modules/jsdom"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    service.start_server(0);
    for (const Cut cut : {Cut::Reset, Cut::HalfOpen, Cut::Stall}) {
        const int number = static_cast<int>(cut);
        const fs::path file = service / ("dive" + std::to_string(number) + ".tar");
        const std::string content(3'000'000, static_cast<char>('a' + number));
        std::ofstream(file, std::ios::binary) << content;
        FlakyProxy proxy(port_of(service.address()),
                         {.cut = cut, .cut_after_bytes = 600'000, .num_cuts = 4});
        Process node({"/usr/bin/env",
                      "node",
                      (scripts / "tus_bad_link.mjs").string(),
                      file.string(),
                      "http://127.0.0.1:" + std::to_string(proxy.port()) + "/api/v1/uploads",
                      GetParam()},
                     service / ".",
                     {{"DIVEMESH_TOKEN", service.token()}});
        EXPECT_EQ(node.wait(120s), 0) << number << ": " << node.stderr_text();
        EXPECT_EQ(proxy.num_cuts(), 4) << number;
        ASSERT_EQ(service.dives().size(), static_cast<std::size_t>(number) + 1);
        const auto dive = service.dives().back();
        EXPECT_EQ(node.stdout_text(), dive.at("id").get<std::string>() + "\n");
        EXPECT_EQ(dive.at("archive_sha256"), sha256_hex(content));
    }
}

TEST_F(UploadTest, TellsTheFindingsOfADiveThatIsRefused) {
    service.start_server(1);
    const fs::path broken = service / "broken";
    fs::copy(small_dive(), broken, fs::copy_options::recursive);
    fs::remove_all(broken / "mav0/cam1");
    const Outcome outcome = service.run({"upload", broken.string(), "--wait"}, 120s);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("cam1"), std::string::npos) << outcome.err;
    EXPECT_EQ(service.dives().at(0).at("state"), "refused");
}

TEST_F(UploadTest, IsRefusedWithoutAToken) {
    service.start_server(0);
    Process client({divemesh_program().string(), "dives", "--json"},
                   service / ".",
                   {{"DIVEMESH_TOKEN", "dm_wrong"}, {"DIVEMESH_SERVER", service.address()}});
    EXPECT_EQ(client.wait(60s), 1);
    EXPECT_NE(client.stdout_text().find("unauthorized"), std::string::npos) << client.stdout_text();
}

}  // namespace
}  // namespace divemesh
