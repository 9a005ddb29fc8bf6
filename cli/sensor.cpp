#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "api/client/upload_state.hpp"
#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/server_options.hpp"
#include "cli/stop_signal.hpp"
#include "sensor/agent.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

struct SensorOptions {
    ServerOptions server;
    std::string id;
    fs::path replay;
    double speed = 1.0;
    fs::path watch;
    double over_after_s = 60.0;
    std::string view = "cam0";
    double back_in_s = 0.0;
    bool upload = false;
    fs::path upload_token_file;
    std::string upload_job;
    double stay_s = 30.0;
    sensor::AgentSettings agent;
};

// Prints events of several threads, line by line.
class Printer {
public:
    explicit Printer(bool as_json) : as_json_(as_json) {}
    void operator()(const std::string& what) const {
        const std::lock_guard lock(*mutex_);
        if (as_json_)
            std::cout << nlohmann::json{{"event", what}}.dump() << std::endl;
        else
            std::cerr << "divemesh sensor: " << what << std::endl;
    }

private:
    bool as_json_;
    std::shared_ptr<std::mutex> mutex_ = std::make_shared<std::mutex>();
};

std::chrono::milliseconds over_after(const SensorOptions& options) {
    return std::chrono::milliseconds(static_cast<std::int64_t>(options.over_after_s * 1000.0));
}

std::unique_ptr<sensor::RecordingSource> source_of(const SensorOptions& options) {
    if (options.replay.empty() == options.watch.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "give exactly one of --replay DIVE and --watch DIR");
    if (!options.replay.empty()) return sensor::replay_dive(options.replay, options.speed);
    sensor::WatchSettings settings;
    settings.over_after = over_after(options);
    return sensor::watch_folder(options.watch, settings);
}

fs::path state_folder_of(const SensorOptions& options) {
    if (!options.agent.state_folder.empty()) return options.agent.state_folder;
    return api::client::default_state_folder() / "sensors" / options.id;
}

sensor::View view_of(const std::string& name) {
    for (const auto view : {sensor::View::Left, sensor::View::Right, sensor::View::Pair})
        if (name == sensor::to_string(view)) return view;
    throw Error(ErrorCode::InvalidArgument, "--view must be cam0, cam1 or pair");
}

sensor::DiveUploadSettings upload_of(const SensorOptions& options, const Printer& print) {
    sensor::DiveUploadSettings settings;
    ServerOptions server = options.server;
    if (!options.upload_token_file.empty()) server.token_file = options.upload_token_file;
    settings.account = account_of(server);
    settings.max_bytes_per_s = options.agent.link.max_bytes_per_s;
    settings.job = options.upload_job;
    settings.on_event = print;
    return settings;
}

sensor::AgentSettings settings_of(const SensorOptions& options, const Printer& print) {
    sensor::AgentSettings settings = options.agent;
    settings.account = account_of(options.server);
    settings.sensor_id = options.id;
    settings.state_folder = state_folder_of(options);
    settings.view = view_of(options.view);
    settings.assess_dive = settings.assess_dive || settings.draw_tracks;
    if (options.back_in_s > 0.0) settings.back_in_s = options.back_in_s;
    settings.link.on_event = print;
    settings.over_after = over_after(options);
    if (options.upload) settings.upload = upload_of(options, print);
    return settings;
}

// Returns whether a replay may end: all messages are on the server, or there was no server for a
// while.
bool is_all_said(const sensor::Agent& agent,
                 sensor::Clock::time_point over_at,
                 const SensorOptions& options) {
    const std::chrono::duration<double> since = sensor::Clock::now() - over_at;
    return since.count() > options.stay_s || (agent.ring().num_waiting() == 0 && since.count() > 1);
}

int run_sensor(const SensorOptions& options, const Context& context) {
    std::signal(SIGXFSZ, SIG_IGN);  // a full quota becomes an error of the write
    const Printer print(context.json);
    std::optional<sensor::Clock::time_point> over_at;
    sensor::AgentSettings settings = settings_of(options, print);
    settings.on_dive_over = [&](const fs::path& dive) {
        print(dive.string() + " has ended");
        over_at = sensor::Clock::now();
    };
    const StopSignal stop;
    sensor::Agent agent(std::move(settings), source_of(options));
    agent.run(stop.token(), [&] {
        return !options.replay.empty() && over_at && !agent.is_uploading() &&
               is_all_said(agent, *over_at, options);
    });
    return agent.has_upload_failed() ? kExitFailed : kExitDone;
}

void add_source_options(CLI::App& command, SensorOptions& options) {
    command.add_option("--id", options.id, "id of this sensor on the server")->required();
    command.add_option(
        "--watch", options.watch, "folder that dives are recorded to (EuRoC layout)");
    command.add_option("--replay", options.replay, "replay this recorded dive as if it were live")
        ->check(CLI::ExistingDirectory);
    command.add_option("--speed", options.speed, "speed factor of the replay")
        ->check(CLI::Range(0.01, 1000.0))
        ->capture_default_str();
    command
        .add_option("--over-after",
                    options.over_after_s,
                    "seconds without a new frame after which a dive has ended; a file "
                    "recording.done in it ends it at once")
        ->check(CLI::Range(5.0, 86'400.0))
        ->capture_default_str();
    command.add_option("--back-in", options.back_in_s, "seconds until the dive is expected back");
}

void add_agent_options(CLI::App& command, SensorOptions& options) {
    sensor::AgentSettings& agent = options.agent;
    command.add_option("--state",
                       agent.state_folder,
                       "folder for messages not yet sent (default: below ~/.local/state)");
    command
        .add_option("--ring-size",
                    agent.ring_bytes,
                    "max size of unsent messages (64M); beyond it the oldest are dropped")
        ->transform(CLI::AsSizeValue(false))
        ->capture_default_str();
    command
        .add_option("--limit-rate",
                    agent.link.max_bytes_per_s,
                    "max bytes per second to send (8k; 0: no limit)")
        ->transform(CLI::AsSizeValue(true));
    command.add_option("--status-every", agent.status_period_s, "seconds between statuses")
        ->check(CLI::Range(0.1, 3600.0))
        ->capture_default_str();
    command
        .add_option("--preview-every",
                    agent.preview_period_s,
                    "seconds between previews; 0: only on command")
        ->check(CLI::Range(0.0, 86'400.0))
        ->capture_default_str();
    command.add_option("--view", options.view, "camera of the previews: cam0, cam1 or pair")
        ->capture_default_str();
    command.add_flag("--quick-look",
                     agent.assess_dive,
                     "track features twice a second and report distance, coverage and drift");
    command.add_flag(
        "--draw-tracks", agent.draw_tracks, "draw the feature tracks into the previews");
    command.add_option("--battery-file",
                       agent.battery_file,
                       "file with the battery's percentage (default: from /sys)");
    command.add_option(
        "--firmware", agent.firmware, "firmware version stated in the hello message");
    command.add_option("--on-command",
                       agent.on_command,
                       "program to run with start_recording or stop_recording as its argument");
    command.add_flag(
        "--allow-set-clock", agent.allow_set_clock, "allow the server to set the clock");
}

void add_upload_options(CLI::App& command, SensorOptions& options) {
    command.add_flag("--upload", options.upload, "upload each dive after it has ended");
    command.add_option("--upload-token-file",
                       options.upload_token_file,
                       "file with a token of scope dives:write (the sensor's own token lacks it)");
    command.add_option("--upload-job", options.upload_job, "preset to reconstruct the dive with");
    command
        .add_option("--stay",
                    options.stay_s,
                    "seconds to wait after a replay until the server has everything")
        ->check(CLI::Range(0.0, 86'400.0))
        ->capture_default_str();
}

}  // namespace

void add_sensor(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand(
        "sensor", "run the agent on a device: send its status and previews to a server");
    auto options = std::make_shared<SensorOptions>();
    options->agent.firmware = "divemesh";
    add_server_options(*command, options->server);
    add_source_options(*command, *options);
    add_agent_options(*command, *options);
    add_upload_options(*command, *options);
    command->footer(
        "The token needs the scope sensor:push for this sensor. Ends at SIGTERM and Ctrl-C; a "
        "replay\n"
        "also ends when everything is sent. Unsent messages are sent at the next start.\n"
        "Exit codes: 0 done, 1 failed, 2 wrong usage.");
    command->callback([options, &context] {
        context.command = [options, &context] { return run_sensor(*options, context); };
    });
}

}  // namespace divemesh::cli
