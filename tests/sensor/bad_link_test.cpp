#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <thread>

#include "sensor/link.hpp"
#include "sensor/preview_maker.hpp"
#include "tests/flaky_proxy.hpp"
#include "tests/sensor/stream_server.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// Wifi at the surface: 64 kbit/s that stop twice without a word.
TEST(BadLinkTest, IsEnoughForAStatusAndAPreviewAfterEachCut) {
    const TemporaryFolder folder;
    StreamServer server;
    const std::string url = server.url();
    const BadLink bad{Cut::Stall, 46'000, 2, 8'000.0};
    const FlakyProxy proxy(std::stoi(url.substr(url.rfind(':') + 1)), bad);
    MessageRing ring(folder / "ring", MessageRing::kLeastBytes, "now");
    Message hello;
    hello.kind = MessageKind::Hello;
    hello.body = "{}";
    ring.append(hello);
    std::vector<Clock::time_point> connected;
    LinkSettings settings;
    settings.on_event = [&](const std::string& what) {
        if (what == "connected") connected.push_back(Clock::now());
    };
    {
        const Link link(
            {api::client::parse_server_url("http://127.0.0.1:" + std::to_string(proxy.port())),
             "t"},
            "rig-1",
            ring,
            settings);
        const auto until = Clock::now() + 40s;
        for (int i = 0; Clock::now() < until; ++i) {
            Message status;
            status.body.append("{\"errors\":[\"").append(200, 'e').append("\"]}");
            ring.append(status);
            Message preview;
            preview.kind = MessageKind::Preview;
            preview.body = R"({"camera":"cam0"})";
            const auto budget = preview_budget(link.state().bytes_per_s);
            preview.jpeg.assign(static_cast<std::size_t>(budget), 'j');
            if (i % 5 == 0) ring.append(preview);
            const auto heard = server.heard();
            const bool has_all = connected.size() == 3 && !heard.empty() &&
                                 heard.back().connection == 2 && Clock::now() > connected[2] + 5s;
            if (has_all) break;
            std::this_thread::sleep_for(1s);
        }
    }
    ASSERT_EQ(connected.size(), 3u);
    for (int i = 0; i < 3; ++i)
        for (const char* kind : {"status", "preview"}) {
            const auto heard = server.heard();
            const auto first = std::find_if(heard.begin(), heard.end(), [&](const Heard& one) {
                return one.connection == i && one.kind == kind && !one.is_historical;
            });
            ASSERT_NE(first, heard.end()) << kind << " on connection " << i;
            const std::chrono::duration<double> after =
                first->at - connected[static_cast<std::size_t>(i)];
            std::cout << kind << " " << after.count() << " s after it was connected\n";
            EXPECT_LT(after.count(), 5.0);
        }
}

}  // namespace
}  // namespace divemesh::sensor
