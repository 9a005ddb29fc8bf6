#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/follow.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scratch.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"
#include "worker/dive/intake.hpp"
#include "worker/pipeline/examine.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

dive::IntakeReport examine(const fs::path& dive) {
    catch_interrupts();
    const ScratchFolder scratch(fs::temp_directory_path());
    ProgressBar bar;
    const auto progress = [&](const Progress& state) {
        throw_if_interrupted();
        show_progress(bar, state);
    };
    return pipeline::examine(dive, scratch.path(), progress, Links::Follow);
}

int validate(const fs::path& dive, const Context& context) {
    const dive::IntakeReport report = examine(dive);
    const bool refused = has_error(report.findings);
    if (context.json) {
        std::cout << nlohmann::json{{"state", refused ? "refused" : "ready"},
                                    {"findings", report.findings},
                                    {"name", report.name},
                                    {"site", report.site},
                                    {"tags", report.tags},
                                    {"content_sha256", report.content_sha256.sha256},
                                    {"num_frames", report.num_frames},
                                    {"duration_s", report.duration_s}}
                         .dump(2)
                  << '\n';
    } else {
        for (const auto& finding : report.findings) std::cout << finding_text(finding);
        std::cout << (refused ? "refused" : "ready") << ": " << report.num_frames << " frames, "
                  << duration_text(report.duration_s) << '\n';
    }
    return refused ? kExitFailed : kExitDone;
}

}  // namespace

void add_validate(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("validate", "check a dive as a server would");
    auto dive = std::make_shared<fs::path>();
    command
        ->add_option("dive", *dive, "folder, archive (zip, tar, tar.gz, tar.zst), ROS bag or MCAP")
        ->required();
    command->callback([dive, &context] {
        context.command = [dive, &context] { return validate(*dive, context); };
    });
}

}  // namespace divemesh::cli
