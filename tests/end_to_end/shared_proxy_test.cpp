// Uploads through a proxy from outside the repository that behaves like bad Wi-Fi.
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

#include "schemas/content_hash.hpp"
#include "schemas/file_descriptor.hpp"
#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr int kNumCuts = 3;

// A socket of loopback: on a port that is free, or connected to one where somebody listens.
class LoopbackSocket {
public:
    explicit LoopbackSocket(int port) {
        address_.sin_family = AF_INET;
        address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        address_.sin_port = htons(static_cast<std::uint16_t>(port));
    }

    bool connects() { return connect(socket_.get(), address(), sizeof address_) == 0; }
    int bound_port() {
        socklen_t size = sizeof address_;
        if (bind(socket_.get(), address(), size) != 0 ||
            getsockname(socket_.get(), address(), &size) != 0)
            return 0;
        return ntohs(address_.sin_port);
    }

private:
    sockaddr* address() { return reinterpret_cast<sockaddr*>(&address_); }

    sockaddr_in address_{};
    FileDescriptor socket_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
};

class SharedProxyTest : public testing::TestWithParam<std::string> {
protected:
    void SetUp() override {
        if (!fs::exists(shared_tool("flaky_proxy.mjs")))
            GTEST_SKIP() << "no " << shared_tool("flaky_proxy.mjs") << ": see DIVEMESH_SHARED";
        service_.start_server(0);
        const std::string pack =
            "tar -C '" + small_dive().string() + "' -cf '" + file_.string() + "' .";
        ASSERT_EQ(std::system(pack.c_str()), 0);
        content_ = read_text(file_);
    }

    Process start_proxy() {
        fs::create_directories(service_ / "proxy");
        port_ = LoopbackSocket(0).bound_port();
        const std::string& server = service_.address();
        Process proxy({"/usr/bin/env",
                       "node",
                       shared_tool("flaky_proxy.mjs").string(),
                       "--listen",
                       std::to_string(port_),
                       "--target",
                       server.substr(server.rfind(':') + 1),
                       "--mode",
                       GetParam(),
                       "--cut-after",
                       std::to_string(content_.size() / (kNumCuts + 2)),
                       "--cuts",
                       std::to_string(kNumCuts)},
                      service_ / "proxy");
        EXPECT_TRUE(wait_until(30s, [&] { return LoopbackSocket(port_).connects(); }));
        return proxy;
    }
    std::string address() const { return "http://127.0.0.1:" + std::to_string(port_); }

    void expect_arrived(Process& proxy) {
        proxy.send(SIGTERM);
        EXPECT_EQ(proxy.wait(30s), 0);
        EXPECT_EQ(nlohmann::json::parse(proxy.stdout_text()).at("cuts"), kNumCuts);
        const auto dives = service_.dives();
        ASSERT_EQ(dives.size(), 1U);
        EXPECT_EQ(dives[0].at("archive_sha256"), sha256_hex(content_));
    }

    Service service_;
    const fs::path file_ = service_ / "dive.tar";
    std::string content_;
    int port_ = 0;
};
INSTANTIATE_TEST_SUITE_P(Modes,
                         SharedProxyTest,
                         testing::Values("reset", "half-open", "stall"),
                         [](const auto& mode) {
                             return mode.param == "half-open" ? "half_open" : mode.param;
                         });

TEST_P(SharedProxyTest, OurUploaderArrives) {
    Process proxy = start_proxy();
    const Outcome outcome = service_.run({"upload",
                                          file_.string(),
                                          "--no-job",
                                          "--json",
                                          "--stall-timeout",
                                          "0.5",
                                          "--server",
                                          address()},
                                         120s);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    expect_arrived(proxy);
}

TEST_P(SharedProxyTest, AStockTusClientArrives) {
    const fs::path scripts = source_directory() / "tests/end_to_end/js";
    if (!fs::exists(scripts / "node_modules/tus-js-client"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    Process proxy = start_proxy();
    Process node({"/usr/bin/env",
                  "node",
                  (scripts / "tus_bad_link.mjs").string(),
                  file_.string(),
                  address() + "/api/v1/uploads",
                  "node"},
                 service_ / ".",
                 {{"DIVEMESH_TOKEN", service_.token()}});
    EXPECT_EQ(node.wait(120s), 0) << node.stderr_text();
    expect_arrived(proxy);
}

}  // namespace
}  // namespace divemesh
