#pragma once

#include <gtest/gtest.h>

#include <string>

#include "storage/token_store.hpp"
#include "tests/server/test_server.hpp"
#include "tests/server/web_socket_client.hpp"

namespace divemesh {

// A server with the sensor "aqua" of the project default, and the frames that the sensor sends.
class SensorFixture : public testing::Test {
protected:
    using json = nlohmann::json;

    SensorFixture() = default;
    explicit SensorFixture(const server::ServerConfig& config) : server_(config) {}

    std::string sensor_token(const std::string& sensor, const std::string& project = "default") {
        return storage::TokenStore(server_.catalog())
            .create(
                {.name = sensor, .project = project, .scopes = {"sensor:push"}, .sensor = sensor})
            .secret;
    }
    RawResponse push(const std::string& token, const json& body, const std::string& id = "aqua") {
        return server_.post_json("/api/v1/sensors/" + id + "/status", token, body);
    }
    json get(const std::string& target) {
        const RawResponse response = server_.request("GET", target, server_.admin());
        EXPECT_EQ(response.status, 200) << response.body;
        return response.json();
    }
    WebSocketClient stream() { return {server_.port(), token_, "/api/v1/sensors/aqua/stream"}; }

    static json report(int sequence,
                       const json& status,
                       const std::string& boot = "boot-1",
                       bool historical = false) {
        return {{"boot_id", boot},
                {"messages",
                 {{{"seq", sequence},
                   {"uptime_ms", 1000 * sequence},
                   {"historical", historical},
                   {"status", status}}}}};
    }
    static json hello(int sequence, const json& capabilities, const std::string& boot = "boot-1") {
        return {{"boot_id", boot},
                {"messages",
                 {{{"seq", sequence},
                   {"uptime_ms", 1000 * sequence},
                   {"hello", {{"firmware", "2.1"}, {"capabilities", capabilities}}}}}}};
    }

    // Returns the markers of a grey JPEG. The server reads no more of an image.
    static std::string jpeg(int width = 64, int height = 48) {
        std::string bytes = "\xFF\xD8\xFF\xC0";
        for (const int byte :
             {0, 11, 8, height >> 8, height & 255, width >> 8, width & 255, 1, 1, 0x11, 0})
            bytes += static_cast<char>(byte);
        return bytes + "\xFF\xDA" + std::string(200, 'x') + "\xFF\xD9";
    }
    static std::string preview_frame(const json& header, const std::string& image) {
        const std::string text = header.dump();
        std::string frame;
        for (int shift = 24; shift >= 0; shift -= 8)
            frame += static_cast<char>(text.size() >> shift & 0xFFU);
        return frame + text + image;
    }
    static json preview_header(int sequence, const json& preview) {
        return {{"boot_id", "boot-1"},
                {"seq", sequence},
                {"uptime_ms", 1000 * sequence},
                {"preview", preview}};
    }

    TestServer server_;
    const std::string token_ = sensor_token("aqua");
};

}  // namespace divemesh
