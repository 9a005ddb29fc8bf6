#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "sensor/commands/command_executor.hpp"
#include "sensor/link/link.hpp"
#include "sensor/preview/dive_assessment.hpp"
#include "sensor/preview/image_check.hpp"
#include "sensor/preview/preview_maker.hpp"
#include "sensor/recording/recording_source.hpp"
#include "sensor/ring/message_ring.hpp"
#include "sensor/uploads/dive_uploads.hpp"

namespace divemesh::sensor {

// What the agent is told on its command line.
struct AgentSettings {
    api::client::Account account;
    std::string sensor_id;
    std::filesystem::path state_folder;  // for the ring and for state that outlives a restart
    std::int64_t ring_bytes = std::int64_t{64} << 20;
    std::string firmware;
    double status_period_s = 1.0;
    double preview_period_s = 5.0;  // 0: only previews by command
    View view = View::Left;
    bool draw_tracks = false;  // only with assess_dive
    bool assess_dive = false;
    double assessment_rate_hz = 2.0;
    std::filesystem::path battery_file;  // "": the machine's own battery
    std::optional<double> back_in_s;     // when the team is expected back, from the start
    std::filesystem::path on_command;    // recording program; "": no recording by command
    bool allow_set_clock = false;
    LinkSettings link;
    // For finished dives. If it has no is_link_good, the stream tells whether the link is good.
    std::optional<DiveUploadSettings> upload;
    std::chrono::milliseconds over_after{60'000};  // of silence, for a dive open at the last stop
    std::function<void(const std::filesystem::path& dive)> on_dive_over;
};

// The agent on the device. It watches the recording, reports a status once a second and a preview
// every few seconds, keeps all messages until the server has them, and carries out commands. run()
// does all of it.
class Agent {
public:
    // Throws Error{Conflict} if another agent uses the state folder.
    Agent(AgentSettings settings, std::unique_ptr<RecordingSource> source);
    ~Agent();

    // Runs until `stop` is requested or `is_enough` returns true. Errors on the way are reported in
    // the status, and it continues.
    void run(const std::stop_token& stop, const std::function<bool()>& is_enough = {});
    // Does one round of run(), for programs with their own loop; call it ten times a second.
    void step(Clock::time_point now);

    const MessageRing& ring() const { return ring_; }
    bool is_uploading() const { return uploads_ && !uploads_->is_idle(); }
    bool has_upload_failed() const { return uploads_ && uploads_->has_failed(); }

private:
    void say_hello();
    void say(MessageKind kind, std::string body, std::string jpeg = "");
    void say_status();
    void scan_dives(Clock::time_point now);
    void check_image();
    void assess_dive();
    std::string preview_as_asked(const nlohmann::json& arguments);
    std::string say_preview(View view, std::int64_t max_bytes);
    cv::Mat shown(View view) const;

    AgentSettings settings_;
    std::unique_ptr<RecordingSource> source_;
    MessageRing ring_;
    CommandExecutor executor_;
    ImageCheck images_;
    std::unique_ptr<DiveAssessment> assessment_;  // of the dive in dive_root_
    std::filesystem::path dive_root_;
    std::optional<FrameImages> frame_;  // the newest that was read
    ImageQuality quality_;              // of the last measured frame, once a second
    Clock::time_point measure_at_;
    Clock::time_point status_at_;
    Clock::time_point preview_at_;
    Clock::time_point assessment_at_;
    std::unique_ptr<Link> link_;            // it reads the ring
    std::unique_ptr<DiveUploads> uploads_;  // last: it uses the link
};

// Returns random letters, new at each start.
std::string new_boot_id();

}  // namespace divemesh::sensor
