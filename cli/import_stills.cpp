#include "cli/import_stills.hpp"

#include <iostream>

#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/imported_text.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scratch.hpp"

namespace divemesh::cli {
std::shared_ptr<recording::StillsOptions> add_stills_options(CLI::App& command) {
    auto stills = std::make_shared<recording::StillsOptions>();
    const auto set_unit = [stills](const std::string& name) {
        stills->times.unit = recording::unit_by_name(name);
    };
    // clang-format off
    command.add_option("--list", stills->times.list, "images: table of time, left and right image; default: the one beside them");
    command.add_option_function<std::string>("--unit", set_unit, "images: unit of the times in names or list")->check(CLI::IsMember({"ns", "us", "ms", "s"}));
    command.add_option("--bayer", stills->pixels.bayer, "images: they are a Bayer mosaic with these colours in the first 2 x 2 pixels")->check(CLI::IsMember({"rggb", "bggr", "gbrg", "grbg"}));
    command.add_option("--bits", stills->pixels.num_bits, "images: bits used of 16, from the lowest on")->check(CLI::Range(8, 16));
    // clang-format on
    return stills;
}

int import_stills(const std::vector<std::filesystem::path>& folders,
                  const recording::ImportOptions& common,
                  const recording::StillsOptions& stills,
                  const Context& context) {
    catch_interrupts();
    ProgressBar bar;
    const auto progress = [&](const Progress& state) {
        throw_if_interrupted();
        show_progress(bar, state);
    };
    recording::StillsOptions options = stills;
    const ScratchFolder scratch(std::filesystem::temp_directory_path());
    options.folders = folders;
    options.scratch = scratch.path();
    options.links = Links::Follow;
    options.out = common.out;
    options.calibration = common.calibration;
    options.metres_per_unit = common.metres_per_unit;
    options.cameras = {common.topics.left, common.topics.right};
    options.imu = common.topics.imu;
    recording::StillsImport imported(options, progress);
    const recording::ImportCounts counts = imported.write(progress);
    if (context.json) {
        nlohmann::json json = imported_json(counts, imported.findings());
        json["cameras"] = imported.sides().rule;
        std::cout << json.dump(2) << '\n';
    } else {
        std::cout << imported_text(counts, imported.findings(), options.out, imported.sides().rule);
    }
    return kExitDone;
}

}  // namespace divemesh::cli
