#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "sensor/link/link.hpp"
#include "sensor/preview/preview_maker.hpp"
#include "tests/flaky_proxy.hpp"
#include "tests/sensor/stream_server.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using namespace std::chrono_literals;

constexpr double kLink_bytes_per_s = 8'000.0;  // 64 kbit/s
constexpr std::size_t kFiveSeconds = 40'000;   // of it

const Heard* find_live(const std::vector<Heard>& heard, int connection, const std::string& kind) {
    const auto found = std::find_if(heard.begin(), heard.end(), [&](const Heard& one) {
        return one.connection == connection && one.kind == kind && !one.is_historical;
    });
    return found == heard.end() ? nullptr : &*found;
}

// What came on its connection before it, and with it.
std::size_t bytes_until(const std::vector<Heard>& heard, const Heard& last) {
    std::size_t num_bytes = 0;
    for (const Heard& one : heard) {
        if (one.connection == last.connection) num_bytes += one.num_bytes;
        if (&one == &last) break;
    }
    return num_bytes;
}

void say_status(MessageRing& ring) {
    Message status;
    status.body.append("{\"errors\":[\"").append(200, 'e').append("\"]}");
    ring.append(status);
}

void say_preview(MessageRing& ring, double bytes_per_s) {
    Message preview;
    preview.kind = MessageKind::Preview;
    preview.body = R"({"camera":"cam0"})";
    preview.jpeg.assign(static_cast<std::size_t>(preview_budget(bytes_per_s)), 'j');
    ring.append(preview);
}

// Wifi at the surface that stops twice without a word. In bytes of the link, not in seconds: how
// long it takes is measured by tests/bench/sensor_window.
TEST(BadLinkTest, AStatusAndAPreviewAreTheFirstAfterEachCut) {
    const TemporaryFolder folder;
    StreamServer server;
    const std::string url = server.url();
    const BadLink bad{Cut::Stall, 46'000, 2, kLink_bytes_per_s};
    const FlakyProxy proxy(std::stoi(url.substr(url.rfind(':') + 1)), bad);
    MessageRing ring(folder / "ring", MessageRing::kMinBytes, "now");
    Message hello;
    hello.kind = MessageKind::Hello;
    hello.body = "{}";
    ring.append(hello);
    {
        const Link link(
            {api::client::parse_server_url("http://127.0.0.1:" + std::to_string(proxy.port())),
             "t"},
            "rig-1",
            ring,
            {});
        const auto until = std::chrono::steady_clock::now() + 90s;
        for (int i = 0; std::chrono::steady_clock::now() < until; ++i) {
            say_status(ring);
            if (i % 5 == 0) say_preview(ring, link.state().bytes_per_s);
            const auto heard = server.heard();
            if (find_live(heard, 2, "preview") != nullptr) break;
            std::this_thread::sleep_for(1s);
        }
    }
    const auto heard = server.heard();
    for (int connection = 0; connection < 3; ++connection)
        for (const char* kind : {"status", "preview"}) {
            const Heard* first = find_live(heard, connection, kind);
            ASSERT_NE(first, nullptr) << kind << " on connection " << connection;
            EXPECT_LT(bytes_until(heard, *first), kFiveSeconds) << kind << " on " << connection;
        }
}

}  // namespace
}  // namespace divemesh::sensor
