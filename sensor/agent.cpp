#include "sensor/agent.hpp"

#include <condition_variable>
#include <mutex>
#include <random>
#include <utility>

#include "schemas/error.hpp"
#include "schemas/wall_clock.hpp"
#include "sensor/clock/uptime.hpp"
#include "sensor/device_state.hpp"
#include "sensor/status_maker.hpp"

namespace divemesh::sensor {
namespace {

using nlohmann::json;

constexpr std::chrono::milliseconds kTick{100};
constexpr double kMeasurePeriod_s = 0.9;  // with a status a second: at each status

Clock::duration seconds(double value) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(value));
}

// Returns whether `next` is reached, and advances it by the period. Missed times are not made up
// for.
bool is_due(Clock::time_point& next, Clock::time_point now, double period_s) {
    if (period_s <= 0.0 || now < next) return false;
    next += seconds(period_s);
    if (next <= now) next = now + seconds(period_s);
    return true;
}

std::optional<View> view_of(const std::string& camera) {
    for (const View view : {View::Left, View::Right, View::Pair})
        if (camera == to_string(view)) return view;
    return std::nullopt;
}

}  // namespace

std::string new_boot_id() {
    std::random_device random;
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string id;
    for (int i = 0; i < 16; ++i) id.push_back(kDigits[random() % kDigits.size()]);
    return id;
}

Agent::Agent(AgentSettings settings, std::unique_ptr<RecordingSource> source)
    : settings_(std::move(settings)),
      source_(std::move(source)),
      ring_(settings_.state_folder / "ring", settings_.ring_bytes, new_boot_id()),
      executor_({settings_.state_folder / "commands.json",
                 settings_.on_command,
                 std::chrono::seconds(30),
                 settings_.allow_set_clock,
                 [this](const json& arguments) { return preview_as_asked(arguments); },
                 uptime_ms,
                 set_machine_clock}) {
    say_hello();
    link_ = std::make_unique<Link>(settings_.account, settings_.sensor_id, ring_, settings_.link);
    if (!settings_.upload) return;
    if (!settings_.upload->is_link_good)
        settings_.upload->is_link_good = [this] { return link_->state().is_connected; };
    uploads_ = std::make_unique<DiveUploads>(
        settings_.state_folder, *settings_.upload, settings_.over_after);
}

Agent::~Agent() = default;

void Agent::say_hello() {
    const json hello = {{"sensor", settings_.sensor_id},
                        {"firmware", settings_.firmware},
                        {"capabilities", executor_.capabilities()},
                        {"clock", is_wall_time_synchronised() ? "synchronised" : "free"}};
    say(MessageKind::Hello, text_of(hello));
}

void Agent::say(MessageKind kind, std::string body, std::string jpeg) {
    Message message;
    message.kind = kind;
    message.uptime_ms = uptime_ms();
    message.time_ms = wall_time_ms();
    message.body = std::move(body);
    message.jpeg = std::move(jpeg);
    ring_.append(std::move(message));
}

void Agent::run(const std::stop_token& stop, const std::function<bool()>& is_enough) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    while (!stop.stop_requested()) {
        step(Clock::now());
        if (is_enough && is_enough()) break;
        never.wait_for(lock, stop, kTick, [] { return false; });
    }
    ring_.sync();
}

void Agent::step(Clock::time_point now) {
    for (const Command& command : link_->take_commands()) executor_.take(command);
    const bool shows = is_due(preview_at_, now, settings_.preview_period_s);
    const bool tells = is_due(status_at_, now, settings_.status_period_s);
    const bool looks =
        settings_.assess_dive && is_due(assessment_at_, now, 1.0 / settings_.assessment_rate_hz);
    if (shows || tells || looks) {
        source_->update(now);
        scan_dives(now);
        check_image();
        if (looks) assess_dive();
    }
    if (tells) say_status();
    if (shows && source_->state().is_recording)
        say_preview(settings_.view, preview_budget(link_->state().bytes_per_s));
    for (const json& outcome : executor_.work()) say(MessageKind::Outcome, text_of(outcome));
    if (tells) ring_.sync();
}

void Agent::scan_dives(Clock::time_point now) {
    if (const auto dive = source_->take_finished()) {
        if (uploads_) uploads_->over(*dive);
        if (settings_.on_dive_over) settings_.on_dive_over(*dive);
    }
    if (uploads_) uploads_->scan(*source_, now);
}

void Agent::check_image() {
    if (source_->dive_root() != dive_root_) {
        dive_root_ = source_->dive_root();
        images_.forget();
        assessment_.reset();
        frame_.reset();
    }
    auto newest = source_->newest_frame();
    if (!newest || (frame_ && frame_->timestamp_ns == newest->timestamp_ns)) return;
    frame_ = std::move(newest);
    // Not at each dive assessment, because it takes longer than decoding the image.
    const bool is_new_dive = !images_.shares();
    if (source_->state().is_recording &&
        (is_due(measure_at_, Clock::now(), kMeasurePeriod_s) || is_new_dive))
        quality_ = images_.check(frame_->left, frame_->timestamp_ns);
}

void Agent::assess_dive() {
    if (!frame_ || !source_->state().is_recording) return;
    const auto before = source_->newest_frame(frame_->timestamp_ns);
    if (!before) return;
    if (!assessment_) assessment_ = std::make_unique<DiveAssessment>(dive_root_);
    assessment_->add(*before, *frame_, quality_);
}

void Agent::say_status() {
    StatusParts parts;
    parts.recording = source_->state();
    parts.images = images_.shares();
    parts.link = link_->state();
    parts.battery = battery_level(settings_.battery_file);
    parts.link_rssi_dbm = link_rssi_dbm();
    parts.is_clock_synchronised = is_wall_time_synchronised();
    parts.uptime_ms = uptime_ms();
    parts.wall_time_ms = wall_time_ms();
    if (settings_.back_in_s) {
        const double left_s = *settings_.back_in_s - static_cast<double>(parts.uptime_ms) / 1000.0;
        if (left_s > 0.0) parts.back_in_s = left_s;
    }
    if (assessment_) parts.assessment = assessment_->report();
    if (const std::string trouble = ring_.trouble(); !trouble.empty())
        parts.errors.push_back("messages are kept only in memory, not on disk: " + trouble);
    if (const std::string trouble = uploads_ ? uploads_->trouble() : ""; !trouble.empty())
        parts.errors.push_back("the list of uploaded dives cannot be saved on disk: " + trouble);
    say(MessageKind::Status, text_of(make_status(parts)));
}

// Makes a preview for a command, with the requested camera and size.
std::string Agent::preview_as_asked(const json& arguments) {
    View view = settings_.view;
    if (arguments.contains("camera")) {
        const json& camera = arguments["camera"];
        const auto asked = camera.is_string() ? view_of(camera.get<std::string>()) : std::nullopt;
        if (!asked) return "there is no such camera: give cam0, cam1 or pair";
        view = *asked;
    }
    std::int64_t max_bytes = preview_budget(link_->state().bytes_per_s);
    if (arguments.contains("max_bytes") && arguments["max_bytes"].is_number_integer())
        max_bytes = arguments["max_bytes"].get<std::int64_t>();
    source_->update(Clock::now());
    check_image();
    return say_preview(view, max_bytes);
}

cv::Mat Agent::shown(View view) const {
    const bool draws = settings_.draw_tracks && view == View::Left && assessment_ &&
                       !assessment_->tracks().empty();
    if (draws) return with_tracks(assessment_->image(), assessment_->tracks());
    return image_of(*frame_, view);
}

// Returns "" or why there is no preview.
std::string Agent::say_preview(View view, std::int64_t max_bytes) {
    if (!frame_) return "there is no image yet";
    const cv::Mat image = shown(view);
    if (image.empty()) return "this camera has no image";
    try {
        Preview preview = make_preview(image, max_bytes);
        json body = {{"camera", to_string(view)},
                     {"captured_ns", frame_->timestamp_ns},
                     {"width", preview.width_px},
                     {"height", preview.height_px}};
        if (const auto shares = images_.shares())
            body["pictures"] = {
                {"dark", shares->dark}, {"blurred", shares->blurred}, {"frozen", shares->frozen}};
        say(MessageKind::Preview, text_of(body), std::move(preview.jpeg));
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

}  // namespace divemesh::sensor
