#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "api/client/dive_tar.hpp"
#include "sensor/uploads/dive_uploads.hpp"
#include "tests/end_to_end/service.hpp"
#include "tests/flaky_proxy.hpp"

namespace divemesh::sensor {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// A server as a process, and a device that records the small dive.
class SensorUploadTest : public testing::Test {
protected:
    SensorUploadTest() {
        service_.start_server(0);
        fs::create_directories(dives_);
    }
    std::string sensor_token() {
        const Outcome made = service_.run({"token",
                                           "create",
                                           "--data",
                                           (service_ / "data").string(),
                                           "--name",
                                           "rig-1",
                                           "--scope",
                                           "sensor:push",
                                           "--sensor",
                                           "rig-1"});
        return made.out.substr(0, made.out.find('\n'));
    }
    // Up to so many frames; all that there are come last.
    void record(const std::string& name, std::size_t num_frames) {
        const fs::path dive = dives_ / name;
        fs::create_directories(dive);
        fs::copy(
            small_dive(), dive, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
        for (const char* camera : {"cam0", "cam1"}) {
            const fs::path table = dive / "mav0" / camera / "data.csv";
            std::istringstream rows(read_text(table));
            std::string kept;
            std::string row;
            for (std::size_t i = 0; i <= num_frames && std::getline(rows, row); ++i)
                kept += row + "\n";
            std::ofstream(table, std::ios::trunc) << kept;
        }
    }
    DiveUploadSettings settings(const std::string& server) {
        DiveUploadSettings settings;
        settings.account = {api::client::parse_server_url(server), service_.token()};
        settings.is_link_good = [] { return true; };
        settings.good_for = 0ms;
        settings.max_bytes_per_s = max_bytes_per_s_;
        settings.on_event = [this](const std::string& what) {
            const std::lock_guard lock(mutex_);
            told_ += what + "\n";
        };
        return settings;
    }
    std::string told() {
        const std::lock_guard lock(mutex_);
        return told_;
    }
    // An agent that runs until it has nothing more to send, or is cut off.
    void send_all(const std::string& server, const std::function<bool()>& is_cut = {}) {
        const auto source = watch_folder(dives_, {});
        DiveUploads uploads(state_, settings(server), 0ms);
        do {
            source->update(Clock::now());
            uploads.scan(*source, Clock::now());
            pause_20_ms();
        } while (!uploads.is_idle() && !(is_cut && is_cut()));
    }
    std::size_t num_uploads_remembered() const {
        std::size_t count = 0;
        for (const auto& entry : fs::directory_iterator(state_))
            count += entry.path().filename().string().starts_with("upload-") ? 1 : 0;
        return count;
    }
    void expect_one_dive() {
        EXPECT_EQ(service_.dives().size(), 1u) << service_.dives().dump(2) << told();
    }

    Service service_;
    fs::path dives_ = service_ / "dives";
    fs::path state_ = service_ / "device";
    double max_bytes_per_s_ = 0.0;
    std::mutex mutex_;
    std::string told_;
};

TEST_F(SensorUploadTest, SendsADiveThatEndedWhileItWasNotRunning) {
    send_all(service_.address());  // the first start
    record("wreck", 1000);
    send_all(service_.address());
    expect_one_dive();
    send_all(service_.address());
    expect_one_dive();
    EXPECT_EQ(num_uploads_remembered(), 0u);
}

TEST_F(SensorUploadTest, LeavesWhatWasThereBeforeTheFirstStart) {
    record("of last year", 1000);
    send_all(service_.address());
    EXPECT_EQ(service_.dives().size(), 0u);
}

TEST_F(SensorUploadTest, GoesOnThroughALinkThatBreaks) {
    send_all(service_.address());
    record("wreck", 1000);
    const std::string& address = service_.address();
    const int port = std::stoi(address.substr(address.rfind(':') + 1));
    for (const Cut cut : {Cut::Reset, Cut::HalfOpen}) {
        SCOPED_TRACE(static_cast<int>(cut));
        fs::remove_all(state_);
        fs::create_directories(state_);
        std::ofstream(state_ / "uploads.json") << "{}";
        const FlakyProxy proxy(port, {cut, 300'000, 3, 0.0});
        send_all("http://127.0.0.1:" + std::to_string(proxy.port()));
        EXPECT_EQ(proxy.num_cuts(), 3);
        EXPECT_NE(told().find("was uploaded as dive"), std::string::npos) << told();
    }
    expect_one_dive();
}

// As the disk is when the power goes: it may stop anywhere.
TEST_F(SensorUploadTest, SendsADiveOnceDespitePowerLossAtAnyPoint) {
    send_all(service_.address());
    record("wreck", 1000);
    const std::string& address = service_.address();
    const int port = std::stoi(address.substr(address.rfind(':') + 1));
    const FlakyProxy link(port, {Cut::Reset, std::int64_t{1} << 40, 0});
    const std::string url = "http://127.0.0.1:" + std::to_string(link.port());
    const auto size = static_cast<std::int64_t>(
        api::client::DiveTar(dives_ / "wreck", Links::LeaveOut).size_bytes());
    max_bytes_per_s_ = static_cast<double>(size) / 3.0;
    for (const std::int64_t sent : {std::int64_t{1}, size / 4, size / 2, size * 3 / 4})
        send_all(url, [&] { return link.num_bytes() >= sent; });
    // What it knows of it until it notes that the dive is there.
    ASSERT_EQ(num_uploads_remembered(), 1u) << told();
    const fs::path before = service_ / "before";
    fs::copy(state_, before, fs::copy_options::recursive);
    const auto num_bytes = link.num_bytes();
    send_all(url);
    EXPECT_LT(link.num_bytes() - num_bytes, size / 2) << "it began anew";
    expect_one_dive();

    fs::copy(before, state_, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    const auto all_bytes = link.num_bytes();
    send_all(url);
    EXPECT_LT(link.num_bytes() - all_bytes, 10'000) << told();
    expect_one_dive();
    EXPECT_EQ(num_uploads_remembered(), 0u);
}

// The program itself, killed while the dive is recorded.
TEST_F(SensorUploadTest, TheProgramSendsADiveThatEndedBeforeItsRestart) {
    const std::string token = (service_ / "token").string();
    std::ofstream(token) << sensor_token();
    const std::string upload_token = (service_ / "upload-token").string();
    std::ofstream(upload_token) << service_.token();
    // clang-format off
    const std::vector<std::string> command = {
        "sensor", "--id", "rig-1", "--watch", dives_.string(), "--state", state_.string(),
        "--token-file", token, "--upload", "--upload-token-file", upload_token, "--over-after", "5"};
    // clang-format on
    {
        Process agent = service_.start(command);
        ASSERT_TRUE(wait_until(20s, [&] { return fs::exists(state_ / "uploads.json"); }))
            << agent.stderr_text();
        record("wreck", 3);
        ASSERT_TRUE(wait_until(20s, [&] {
            return read_text(state_ / "uploads.json").find("open") != std::string::npos;
        })) << agent.stderr_text();
        agent.kill();
    }
    record("wreck", 1000);
    Process agent = service_.start(command);
    EXPECT_TRUE(wait_until(
        60s,
        [&] { return read_text(state_ / "uploads.json").find("\"sent\"}") != std::string::npos; }))
        << agent.stderr_text() << read_text(state_ / "uploads.json");
    expect_one_dive();
}

}  // namespace
}  // namespace divemesh::sensor
