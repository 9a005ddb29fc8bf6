// Connections that cannot be accepted.
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sstream>
#include <sys/resource.h>
#include <thread>
#include <unistd.h>

#include "server/warning_pace.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh::server {
namespace {

using namespace std::chrono_literals;

TEST(WarningPaceTest, OneOfAnIntervalGoesThroughAndCountsTheOthers) {
    WarningPace pace(30s);
    const WarningPace::Clock::time_point start{};
    EXPECT_EQ(pace.pass(start), 0);
    for (int i = 1; i < 600; ++i) EXPECT_EQ(pace.pass(start + i * 50ms), std::nullopt);
    EXPECT_EQ(pace.pass(start + 30s), 599);
    EXPECT_EQ(pace.pass(start + 59s), std::nullopt);
    EXPECT_EQ(pace.pass(start + 90s), 1);
}

// Leaves this process room for one more open file.
class FewOpenFiles {
public:
    FewOpenFiles() {
        getrlimit(RLIMIT_NOFILE, &before_);
        const int next = dup(STDIN_FILENO);
        close(next);
        rlimit few = before_;
        few.rlim_cur = static_cast<rlim_t>(next) + 1;
        setrlimit(RLIMIT_NOFILE, &few);
    }
    ~FewOpenFiles() { setrlimit(RLIMIT_NOFILE, &before_); }
    FewOpenFiles(const FewOpenFiles&) = delete;
    FewOpenFiles& operator=(const FewOpenFiles&) = delete;

private:
    rlimit before_{};
};

TEST(AcceptTest, WithoutOpenFilesOneLineOfTheLogSaysSo) {
    std::ostringstream log;
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
    TestServer server;
    server.request("GET", "/healthz/live", "");
    {
        const FewOpenFiles few;
        const int client = socket(AF_INET, SOCK_STREAM, 0);
        ASSERT_GE(client, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<std::uint16_t>(server.port()));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        ASSERT_EQ(connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        std::this_thread::sleep_for(1s);  // twenty attempts
        close(client);
    }
    EXPECT_EQ(server.request("GET", "/healthz/live", "").status, 200);
    server.stop();
    spdlog::set_default_logger(before);
    int num_lines = 0;
    const std::string text = log.str();
    for (std::size_t at = text.find("accept_failed"); at != std::string::npos;
         at = text.find("accept_failed", at + 1))
        ++num_lines;
    EXPECT_EQ(num_lines, 1) << text;
}

}  // namespace
}  // namespace divemesh::server
