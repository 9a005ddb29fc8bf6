#include <iostream>
#include <memory>
#include <optional>
#include <system_error>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/follow.hpp"
#include "cli/interrupt.hpp"
#include "cli/metrics_table.hpp"
#include "cli/preset_options.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scratch.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"
#include "schemas/verdict.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

struct ReconstructOptions {
    fs::path dive;
    fs::path out;
    PresetOptions preset;
    nlohmann::json overrides = nlohmann::json::object();  // of the options with a flag of their own
    bool no_texture = false;
    bool explain = false;
};

int print_options(const ReconstructionOptions& options, const Context& context) {
    if (context.json) {
        std::cout << options_to_json(options).dump(2) << '\n';
        return kExitDone;
    }
    std::vector<std::vector<std::string>> rows = {{"OPTION", "VALUE", "WHAT IT IS"}};
    for (const auto& row : divemesh::explain(options))
        rows.push_back({row.name, row.value, row.text});
    std::cout << table_text(rows);
    return kExitDone;
}

// Prints the findings on a dive that is refused, as `divemesh validate` does.
void print_refusal(const std::vector<Finding>& findings) {
    if (!has_error(findings)) return;
    for (const Finding& finding : findings) std::cerr << finding_text(finding);
}

// Prints metrics, findings and verdict. Returns the exit code: a result that is not usable is a
// failure, and what there is of it stays in its folder.
int print_result(const nlohmann::json& metrics, const fs::path& out, const Context& context) {
    const auto findings = metrics.at("findings").get<std::vector<Finding>>();
    if (context.json)
        std::cout << metrics.dump(2) << '\n';
    else
        std::cout << metrics_summary(metrics) << verdict_text(findings);
    const auto error = first_error(findings);
    if (!error) return kExitDone;
    std::cerr << "divemesh: " << error->message << ": partial results are in " << out.string()
              << ", " << error->remedy << '\n';
    return kExitFailed;
}

nlohmann::json run_with_bar(const pipeline::ReconstructionRequest& request) {
    catch_interrupts();
    ProgressBar bar;
    return pipeline::reconstruct_dive(request, [&](const Progress& progress) {
        throw_if_interrupted();
        show_progress(bar, progress);
    });
}

// Makes the output folder, unless there is no dive.
void make_output_folder(const fs::path& dive, const fs::path& out) {
    if (!fs::exists(dive))
        throw Error(ErrorCode::NotFound, "cannot open " + dive.string() + ": check the path");
    std::error_code error;
    fs::create_directories(out, error);
    if (error)
        throw Error(ErrorCode::InvalidArgument,
                    "cannot make the folder " + out.string() + ": " + error.message() +
                        ": give another --out");
}

int reconstruct(const ReconstructOptions& options, const Context& context) {
    nlohmann::json overrides = options.overrides;
    overrides.update(overrides_of(options.preset.set));
    if (options.no_texture) overrides["texture"] = false;
    const auto chosen = make_options(options.preset.preset, overrides);
    if (options.explain) return print_options(chosen, context);
    if (options.dive.empty() || options.out.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "no dive or no output folder: give DIVE and --out DIR");
    make_output_folder(options.dive, options.out);
    const ScratchFolder scratch(options.out);
    pipeline::ReconstructionRequest request;
    request.dive = options.dive;
    request.links = Links::Follow;
    request.out = options.out;
    request.scratch = scratch.path();
    request.resumable = false;  // the folder is removed after this run
    request.preset = options.preset.preset;
    request.options = chosen;
    request.dive_checked = print_refusal;
    return print_result(run_with_bar(request), options.out, context);
}

// Adds a flag for one option of the preset.
template <typename Value>
void add_override(CLI::App& command,
                  const std::shared_ptr<ReconstructOptions>& options,
                  const std::string& flag,
                  const std::string& name,
                  const std::string& text) {
    command.add_option_function<Value>(
        flag, [options, name](const Value& value) { options->overrides[name] = value; }, text);
}

}  // namespace

void add_reconstruct(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("reconstruct", "reconstruct a dive on this machine");
    auto options = std::make_shared<ReconstructOptions>();
    command->add_option(
        "dive", options->dive, "folder, archive (zip, tar, tar.gz, tar.zst), ROS bag or MCAP");
    command->add_option("--out",
                        options->out,
                        "output folder, created if missing; an earlier result in it is removed");
    add_preset_options(*command, options->preset);
    add_override<int>(*command,
                      options,
                      "--threads",
                      "num_threads",
                      "0: all cores; the result does not depend on it");
    add_override<std::string>(
        *command, options, "--stereo", "stereo", "stereo matcher: block, sgm or opencv_sgbm");
    add_override<std::string>(
        *command, options, "--mesher", "mesher", "mesher: surface_nets or marching_cubes");
    add_override<double>(*command,
                         options,
                         "--voxel-m",
                         "voxel_m",
                         "edge of all voxels, m; 0: chosen locally from rig and range");
    add_override<double>(*command,
                         options,
                         "--max-sigma",
                         "max_sigma_m",
                         "remove surface whose standard deviation is larger, m; 0: no limit");
    add_override<double>(
        *command, options, "--simplify", "simplify", "share of the triangles to keep, 0 to 1");
    add_override<std::string>(*command,
                              options,
                              "--color",
                              "color",
                              "colours: raw (as recorded) or restored (without the water)");
    add_override<std::string>(*command,
                              options,
                              "--white-point",
                              "white_point",
                              "r,g,b: color.white_point in metrics.json of an earlier dive of the "
                              "place, to compare restored colours");
    command->add_flag("--no-texture",
                      options->no_texture,
                      "leave out the photographs on mesh.glb and the mosaic");
    command->add_flag(
        "--explain", options->explain, "print every option with its value and meaning");
    command->callback([options, &context] {
        context.command = [options, &context] { return reconstruct(*options, context); };
    });
}

}  // namespace divemesh::cli
