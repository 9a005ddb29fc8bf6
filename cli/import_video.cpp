#include "cli/import_video.hpp"

#include <iostream>
#include <map>
#include <string>

#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/imported_text.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/text.hpp"
#include "worker/base/text.hpp"

namespace divemesh::cli {
namespace {

std::string size_text(const video::VideoTraits& traits) {
    std::string text = std::to_string(traits.upright_width_px());
    text += " x ";
    text += std::to_string(traits.upright_height_px());
    return text;
}

// Returns the name of a video, with the number of its files if they are several.
std::string name_text(const video::IndexedVideo& video) {
    if (video.parts.size() == 1) return video.name();
    return video.name() + " (" + std::to_string(video.parts.size()) + " chapters)";
}

// Returns the table of what the videos are.
std::string videos_text(const recording::VideoImport& imported) {
    std::vector<std::vector<std::string>> rows = {
        {"video", "codec", "size [px]", "frames", "a second", "sound", "telemetry"}};
    for (const video::IndexedVideo& video : imported.videos()) {
        const video::VideoTraits& traits = video.index.traits;
        rows.push_back({name_text(video),
                        traits.codec,
                        size_text(traits),
                        std::to_string(video.index.stamps_ns.size()),
                        base::fixed(traits.rate_hz, 2),
                        traits.has_audio ? "yes" : "no",
                        traits.has_gpmf ? "GPMF" : "no"});
    }
    return table_text(rows);
}

nlohmann::json videos_json(const recording::VideoImport& imported) {
    nlohmann::json list = nlohmann::json::array();
    for (const video::IndexedVideo& video : imported.videos()) {
        const video::VideoTraits& traits = video.index.traits;
        list.push_back({{"file", video.name()},
                        {"num_chapters", video.parts.size()},
                        {"codec", traits.codec},
                        {"width_px", traits.upright_width_px()},
                        {"height_px", traits.upright_height_px()},
                        {"num_frames", video.index.stamps_ns.size()},
                        {"rate_hz", traits.rate_hz},
                        {"has_sound", traits.has_audio},
                        {"has_telemetry", traits.has_gpmf}});
    }
    return list;
}

const std::map<std::string, recording::VideoLayout> kLayouts = {
    {"two-files", recording::VideoLayout::TwoFiles},
    {"side-by-side", recording::VideoLayout::SideBySide},
    {"over-under", recording::VideoLayout::OverUnder}};

}  // namespace

std::shared_ptr<recording::VideoImportOptions> add_video_options(CLI::App& command) {
    auto video = std::make_shared<recording::VideoImportOptions>();
    // clang-format off
    command.add_option("--layout", video->layout, "videos: how one holds both cameras, side-by-side or over-under")->transform(CLI::CheckedTransformer(kLayouts));
    command.add_option("--offset", video->offset_s, "videos: time of a moment in the left one minus its time in the right one, s; default: by sound, file times or motion");
    // clang-format on
    return video;
}

int import_video(const std::vector<std::filesystem::path>& videos,
                 const recording::ImportOptions& common,
                 const recording::VideoImportOptions& video,
                 const Context& context) {
    recording::VideoImportOptions options = video;
    options.videos = videos;
    options.out = common.out;
    options.calibration = common.calibration;
    options.metres_per_unit = common.metres_per_unit;
    options.imu = common.topics.imu;
    catch_interrupts();
    ProgressBar bar;
    const auto progress = [&](const Progress& state) {
        throw_if_interrupted();
        show_progress(bar, state);
    };
    recording::VideoImport imported(options, progress);
    if (!context.json) std::cout << videos_text(imported) << std::flush;
    const recording::ImportCounts counts = imported.write(progress);
    if (context.json) {
        nlohmann::json json = imported_json(counts, imported.findings());
        json["videos"] = videos_json(imported);
        std::cout << json.dump(2) << '\n';
        return kExitDone;
    }
    std::cout << imported_text(counts, imported.findings(), options.out);
    return kExitDone;
}

}  // namespace divemesh::cli
