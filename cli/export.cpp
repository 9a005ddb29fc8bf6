#include <iostream>
#include <memory>
#include <optional>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "schemas/error.hpp"
#include "worker/io/exports.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
    fs::path reconstruction;
    fs::path out;
    std::string formats;
    std::optional<double> latitude_deg;
    std::optional<double> longitude_deg;
    std::optional<double> x_azimuth_deg;
};

// An option overrides the position in dive.json.
std::optional<types::GeographicPosition> position(const ExportOptions& options,
                                                  const io::ReconstructionFolder& reconstruction) {
    if (!options.latitude_deg) return io::position_of(reconstruction);
    return types::GeographicPosition{
        *options.latitude_deg, *options.longitude_deg, options.x_azimuth_deg};
}

int run(const ExportOptions& options, const Context& context) {
    const auto formats = io::export_formats(options.formats);
    const io::ReconstructionFolder reconstruction(options.reconstruction);
    const fs::path out = options.out.empty() ? options.reconstruction : options.out;
    const auto place = position(options, reconstruction);
    const auto names = io::export_reconstruction(reconstruction, formats, place, out);
    nlohmann::json files = nlohmann::json::array();
    for (const std::string& name : names) files.push_back((out / name).string());
    if (context.json)
        std::cout << nlohmann::json{{"files", files}}.dump(2) << '\n';
    else
        for (const auto& file : files) std::cout << file.get<std::string>() << '\n';
    return kExitDone;
}

}  // namespace

void add_export(CLI::App& app, Context& context) {
    auto* command =
        app.add_subcommand("export", "write files of a reconstruction for other programs");
    auto options = std::make_shared<ExportOptions>();
    command->add_option("reconstruction", options->reconstruction, "folder of a reconstruction")
        ->required();
    command
        ->add_option("--format",
                     options->formats,
                     "kitti, euroc (trajectory), obj, ply, las, laz, 3dtiles (mesh), "
                     "e57 (points), geotiff (mosaic, heights), "
                     "colmap, nerfstudio, mcap (keyframes and points); separate several by commas")
        ->required();
    command->add_option(
        "--out", options->out, "output folder; default: the folder of the reconstruction");
    auto* latitude = command->add_option(
        "--latitude", options->latitude_deg, "latitude of the first pose, degrees, WGS 84");
    auto* longitude = command->add_option(
        "--longitude", options->longitude_deg, "longitude of the first pose, degrees, WGS 84");
    latitude->needs(longitude);
    longitude->needs(latitude);
    command
        ->add_option("--x-azimuth",
                     options->x_azimuth_deg,
                     "azimuth of the world's x axis, clockwise from true north, degrees")
        ->needs(latitude);
    command->callback([options, &context] {
        context.command = [options, &context] { return run(*options, context); };
    });
}

}  // namespace divemesh::cli
