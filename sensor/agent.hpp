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

struct AgentSettings {
    api::client::Account account;
    std::string sensor_id;
    std::filesystem::path state_folder;  // of the ring and of what has to outlive a restart
    std::int64_t ring_bytes = std::int64_t{64} << 20;
    std::string firmware;
    double status_period_s = 1.0;
    double preview_period_s = 5.0;  // 0: none but those that are asked for
    View view = View::Left;
    bool draw_tracks = false;  // with the quick look
    bool quick_look = false;
    double assessment_rate_hz = 2.0;
    std::filesystem::path battery_file;  // "": what the machine says
    std::optional<double> back_in_s;     // when the team is expected back, from the start
    std::filesystem::path on_command;    // "": no recording by command
    bool allow_set_clock = false;
    LinkSettings link;
    // Of the dives that are over; whether the link is good is seen from the stream unless it says.
    std::optional<DiveUploadSettings> upload;
    std::chrono::milliseconds over_after{60'000};  // silence of a dive that was open at the stop
    std::function<void(const std::filesystem::path& dive)> on_dive_over;
};

// The agent on the device: looks at what is recorded, says how it is once a second and what it sees
// every few, keeps all of it until the server has it, and does what it is asked to. run() is the
// whole of it.
class Agent {
public:
    // Throws Error{Conflict} when another agent uses the state folder.
    Agent(AgentSettings settings, std::unique_ptr<RecordingSource> source);
    ~Agent();

    // Until it is to stop, or `is_enough`. What went wrong on the way is told in the status and
    // goes on.
    void run(const std::stop_token& stop, const std::function<bool()>& is_enough = {});
    // One round of run(); for programs with a loop of their own, ten times a second.
    void step(Clock::time_point now);

    const MessageRing& ring() const { return ring_; }
    LinkState link_state() const { return link_->state(); }
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
    std::unique_ptr<DiveAssessment> assessment_;  // of the dive below
    std::filesystem::path dive_root_;
    std::optional<FrameImages> frame_;  // the newest that was looked at
    ImageQuality quality_;              // of the last that was measured, once a second
    Clock::time_point measure_at_;
    Clock::time_point status_at_;
    Clock::time_point preview_at_;
    Clock::time_point assessment_at_;
    std::unique_ptr<Link> link_;            // it reads the ring
    std::unique_ptr<DiveUploads> uploads_;  // last: it asks the link
};

// Of random letters, new at each start.
std::string new_boot_id();

}  // namespace divemesh::sensor
