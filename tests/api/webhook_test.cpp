#include <gtest/gtest.h>

#include "api/webhook_signature.hpp"
#include "api/webhook_target.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

namespace ip = boost::asio::ip;

// The example from the reference libraries of the Standard Webhooks specification.
TEST(WebhookTest, SignsAsTheSpecificationsExample) {
    EXPECT_EQ(webhook_signature("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw",
                                "msg_p5jXN8AQM9LWM0D4loKWxJek",
                                1614265330,
                                R"({"test": 2432232314})"),
              "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
    EXPECT_EQ(webhook_secret("00ff"), "whsec_AP8=");
}

TEST(WebhookTest, ReadsPlainAddressesAlone) {
    const auto target = parse_webhook_url("https://hooks.example.org/a/b?c=d");
    EXPECT_TRUE(target.tls);
    EXPECT_EQ(target.host, "hooks.example.org");
    EXPECT_EQ(target.port, "443");
    EXPECT_EQ(target.path, "/a/b?c=d");
    EXPECT_EQ(parse_webhook_url("https://[2606:4700::1111]:8443").host, "2606:4700::1111");
    EXPECT_EQ(parse_webhook_url("http://127.0.0.1:9000/x").port, "9000");
    for (const char* url : {"",
                            "hooks.example.org",
                            "file:///etc/passwd",
                            "gopher://example.org/",
                            "ftp://example.org/",
                            "https://",
                            "https:///x",
                            "https://user@example.org/",
                            "https://example.org@127.0.0.1/",
                            "https://example.org:22/",
                            "https://example.org:0/",
                            "https://example.org:65536/",
                            "https://example.org:-1/",
                            "https://example.org:/",
                            "https://example.org\\@127.0.0.1/",
                            "https://example.org/#x",
                            "https://example.org /",
                            "https://example.org/\r\nHost: x",
                            "https://ex\xc3\xa4mple.org/",
                            "http://2130706433/",
                            "http://017700000001/",
                            "http://0x7f.1/",
                            "http://127.1/",
                            "http://0177.0.0.1/",
                            "http://[::1/",
                            "http://[127.0.0.1]x/",
                            "http://[fe80::1%25eth0]/"})
        EXPECT_THROW(parse_webhook_url(url), Error) << url;
}

TEST(WebhookTest, KnowsWhichAddressesAreNotPublic) {
    for (const char* address : {"127.0.0.1",
                                "127.255.255.254",
                                "0.0.0.0",
                                "10.1.2.3",
                                "100.64.0.1",
                                "169.254.169.254",
                                "172.16.0.1",
                                "172.31.255.255",
                                "192.168.1.1",
                                "198.18.0.1",
                                "224.0.0.1",
                                "255.255.255.255",
                                "::",
                                "::1",
                                "::ffff:127.0.0.1",
                                "::ffff:8.8.8.8",
                                "64:ff9b::7f00:1",
                                "fe80::1",
                                "fc00::1",
                                "fd12:3456::1",
                                "ff02::1",
                                "2001:db8::1",
                                "2002:7f00:1::1"})
        EXPECT_FALSE(is_public(ip::make_address(address))) << address;
    for (const char* address : {"8.8.8.8", "172.32.0.1", "100.128.0.1", "2606:4700::1111"})
        EXPECT_TRUE(is_public(ip::make_address(address))) << address;
}

TEST(WebhookTest, ReachesNetworksThatAreAllowed) {
    const AllowedNetworks networks({"10.1.0.0/16", "127.0.0.1", "fd00::/8"});
    for (const char* address : {"10.1.255.1", "127.0.0.1", "fd12::1"})
        EXPECT_TRUE(networks.contains(ip::make_address(address))) << address;
    for (const char* address : {"10.2.0.1", "127.0.0.2", "fe80::1", "::ffff:127.0.0.1"})
        EXPECT_FALSE(networks.contains(ip::make_address(address))) << address;
    for (const char* text : {"", "x", "10.0.0.0/33", "10.0.0.0/", "10.0.0.0/-1", "10.1"})
        EXPECT_THROW(AllowedNetworks({text}), Error) << text;
}

}  // namespace
}  // namespace divemesh::api
