#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <unistd.h>

#include "api/browser_session.hpp"
#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/send_dive.hpp"
#include "cli/server_options.hpp"
#include "cli/server_process.hpp"
#include "schemas/reconstruction_options.hpp"
#include "storage/catalog.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

// As much as two cores render and reconstruct in half a minute.
constexpr double kPath_m = 2.0;
constexpr int kWidth_px = 512;
constexpr int kHeight_px = 384;

struct DemoOptions {
    fs::path dive;
    fs::path out = "divemesh-demo";
    std::string preset = "standard";
    bool keep = isatty(STDOUT_FILENO) != 0;
};

// Returns the folder of a rendered dive. It gets its name when it is complete, and is not rendered
// again by the next demo.
fs::path rendered_dive(const fs::path& out) {
    const fs::path dive = out / "barge";
    if (fs::exists(dive)) return dive;
    const fs::path part = out / "barge.part";
    fs::remove_all(part);
    catch_interrupts();
    ProgressBar bar;
    bar.say("rendering a dive along a sunken barge: " + dive.string());
    simulator::SimulateOptions options;
    options.out = part;
    options.length_m = kPath_m;
    options.width_px = kWidth_px;
    options.height_px = kHeight_px;
    simulator::simulate(options, [&](const Progress& progress) {
        throw_if_interrupted();
        show_progress(bar, progress);
    });
    fs::rename(part, dive);
    return dive;
}

// Lets the desktop's browser open an address, if there is a desktop.
void open_in_browser(const std::string& url) {
    if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
    if (fork() != 0) return;
    if (freopen("/dev/null", "w", stdout) == nullptr ||
        freopen("/dev/null", "w", stderr) == nullptr)
        _exit(127);
    execlp("xdg-open", "xdg-open", url.c_str(), nullptr);
    _exit(127);
}

// Opens the page and serves it until it is interrupted.
void show_page(ServerProcess& server, const fs::path& data) {
    const storage::Catalog catalog("sqlite://" + (fs::canonical(data) / "catalog.db").string());
    const auto sign_in = [&] { return server.url() + api::make_sign_in_path(catalog, "", "demo"); };
    open_in_browser(sign_in());
    std::cerr << "open " << sign_in() << "\n(signs a browser in once, within 15 minutes)\n"
              << "press Ctrl-C to end\n";
    std::signal(SIGINT, SIG_IGN);  // the server of this terminal gets it too, and ends
    server.wait();
}

int demo(const DemoOptions& options, const Context& context) {
    make_options(options.preset, nlohmann::json::object());
    fs::create_directories(options.out);
    const fs::path dive = options.dive.empty() ? rendered_dive(options.out) : options.dive;
    const fs::path data = options.out / "data";
    const fs::path results = options.out / "result";
    ServerProcess server(data, options.out / "server.log");
    ServerOptions account;
    account.server = server.url();
    account.token_file = data / "admin.token";
    api::client::RestClient rest(account_of(account));
    SendOptions send;
    send.dive = dive;
    send.preset.preset = options.preset;
    const SentDive sent = send_dive(rest, send);
    if (!fetch_results(rest, sent.job_id, results)) return kExitFailed;
    const std::string mesh = (results / "mesh.glb").string();
    if (context.json)
        std::cout
            << nlohmann::json{{"dive", sent.dive.id}, {"job", sent.job_id}, {"mesh", mesh}}.dump(2)
            << std::endl;
    else
        std::cout << mesh << std::endl;
    if (options.keep) show_page(server, data);
    return kExitDone;
}

}  // namespace

void add_demo(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand(
        "demo", "render a dive, upload it to a server of its own, reconstruct it, open the page");
    auto options = std::make_shared<DemoOptions>();
    command
        ->add_option("dive",
                     options->dive,
                     "a recording of your own instead: folder, archive, ROS bag or MCAP")
        ->check(CLI::ExistingPath);
    command->add_option("--out", options->out, "folder for all of it, created if missing")
        ->capture_default_str();
    command->add_option("--preset", options->preset, "paper, fast, standard or accurate")
        ->capture_default_str();
    command->add_flag("--keep,!--no-keep",
                      options->keep,
                      "keep the server and open its page until Ctrl-C; default: at a terminal");
    command->footer("Prints the path of the mesh. A second demo in that folder shows it again.");
    command->callback([options, &context] {
        context.command = [options, &context] { return demo(*options, context); };
    });
}

}  // namespace divemesh::cli
