#include <gtest/gtest.h>

#include <cstdlib>

#include "sensor/link/link.hpp"
#include "tests/end_to_end/service.hpp"

namespace divemesh::sensor {
namespace {

using namespace std::chrono_literals;

// A server with a certificate of its own, and a device that has something to say.
class SensorTlsTest : public testing::Test {
protected:
    void SetUp() override {
        const std::string data = folder_ / "data";
        const std::string cert = folder_ / "cert.pem";
        const std::string key = folder_ / "key.pem";
        const std::string made =
            "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=lab "
            "-addext subjectAltName=IP:127.0.0.1 -keyout '" +
            key + "' -out '" + cert + "' 2>/dev/null";
        ASSERT_EQ(std::system(made.c_str()), 0);
        const std::string program = divemesh_program();
        Process token({program,
                       "token",
                       "create",
                       "--data",
                       data,
                       "--name",
                       "rig-1",
                       "--scope",
                       "sensor:push",
                       "--sensor",
                       "rig-1"},
                      folder_.path());
        ASSERT_EQ(token.wait(60s), 0) << token.stderr_text();
        token_ = token.stdout_text().substr(0, token.stdout_text().find('\n'));
        server_.emplace(std::vector<std::string>{program,
                                                 "serve",
                                                 "--data",
                                                 data,
                                                 "--listen",
                                                 "127.0.0.1:0",
                                                 "--workers",
                                                 "0",
                                                 "--tls-cert",
                                                 cert,
                                                 "--tls-key",
                                                 key},
                        folder_.path());
        ASSERT_TRUE(wait_until(60s, [&] {
            return server_->stdout_text().find("listening on ") != std::string::npos;
        })) << server_->stderr_text();
        const std::string text = server_->stdout_text();
        const std::size_t at = text.find("https://");
        ASSERT_NE(at, std::string::npos) << text;
        account_.server =
            api::client::parse_server_url(text.substr(at, text.find_first_of(" \n", at) - at));
        account_.token = token_;
        ring_.append(status());
    }
    static Message status() {
        Message status;
        status.body = R"({"battery":0.5})";
        return status;
    }

    TemporaryFolder folder_;
    std::optional<Process> server_;
    std::string token_;
    api::client::Account account_;
    MessageRing ring_{folder_ / "ring", MessageRing::kMinBytes, "boot-1"};
};

TEST_F(SensorTlsTest, SendsToATrustedServer) {
    account_.server.ca_file = folder_ / "cert.pem";
    const Link link(account_, "rig-1", ring_, {});
    EXPECT_TRUE(wait_until(20s, [&] { return ring_.num_waiting() == 0; })) << link.state().trouble;
    EXPECT_TRUE(link.state().is_connected);
}

TEST_F(SensorTlsTest, SendsNothingToAnUntrustedServer) {
    const Link link(account_, "rig-1", ring_, {});
    EXPECT_TRUE(wait_until(20s, [&] {
        return link.state().trouble.find("certificate") != std::string::npos;
    })) << link.state().trouble;
    EXPECT_EQ(ring_.num_waiting(), 1u);
}

}  // namespace
}  // namespace divemesh::sensor
