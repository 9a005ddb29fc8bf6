#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/interrupt.hpp"
#include "cli/jobs_by_server.hpp"
#include "cli/progress_bar.hpp"
#include "cli/report_text.hpp"
#include "cli/scratch.hpp"
#include "cli/server_options.hpp"
#include "schemas/requirement.hpp"
#include "worker/report/accuracy_report.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
    std::string subject;  // folder of a reconstruction; on a server a dive or a job
    ServerOptions server;
    bool wait = true;
    fs::path dive;
    fs::path ground_truth;
    fs::path reference;
    fs::path measurements;
    fs::path areas;
    std::string lever_arm;
    std::string time_offset;
    std::vector<std::string> requirements;
    fs::path out;
    fs::path junit;
    int num_threads = 0;
};

std::optional<fs::path> given(const fs::path& path) {
    return path.empty() ? std::nullopt : std::optional<fs::path>(path);
}

int finish(const nlohmann::json& report, const Context& context) {
    std::cerr << report_findings(report);
    std::cout << (context.json ? report.dump(2) + "\n" : report_summary(report));
    return report.at("passed") == false ? kExitRequirementUnmet : kExitDone;
}

int report_here(const ReportOptions& options, const Context& context) {
    const fs::path folder = options.subject;
    report::AccuracyReportRequest request;
    request.reconstruction = folder;
    request.dive = given(options.dive);
    request.links = Links::Follow;
    request.out = options.out.empty() ? folder / "accuracy" : options.out;
    request.ground_truth = given(options.ground_truth);
    request.reference = given(options.reference);
    request.measurements = given(options.measurements);
    request.areas = given(options.areas);
    request.requirements = options.requirements;
    request.num_threads = options.num_threads;
    if (!options.lever_arm.empty()) set_lever_arm(request.truth, options.lever_arm);
    if (!options.time_offset.empty()) set_time_offset(request.truth, options.time_offset);
    for (const std::string& text : options.requirements) parse_requirement(text);
    if (!fs::exists(folder / "metrics.json"))
        throw Error(
            ErrorCode::NotFound,
            "no metrics.json in " + folder.string() +
                ": give the folder that `divemesh reconstruct --out` or `divemesh download` wrote");
    fs::create_directories(request.out);
    const ScratchFolder scratch(request.out);
    request.scratch = scratch.path();
    catch_interrupts();
    nlohmann::json report;
    {
        ProgressBar bar;
        report = report::make_accuracy_report(request, [&](const Progress& progress) {
            throw_if_interrupted();
            show_progress(bar, progress);
        });
    }
    if (!options.junit.empty())
        fs::copy_file(
            request.out / "junit.xml", options.junit, fs::copy_options::overwrite_existing);
    return finish(report, context);
}

void write_text(const fs::path& file, const std::string& text) {
    std::ofstream stream(file, std::ios::binary);
    stream << text;
    stream.close();
    if (!stream) throw Error(ErrorCode::OutOfSpace, "cannot write " + file.string());
}

// Makes the report on a server: sends the truth, downloads the report.
int report_there(const ReportOptions& options, const Context& context) {
    if (!options.dive.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "--dive cannot be used with --server, which has the dive of " +
                        options.subject + ": leave it out");
    ServerJob wanted{.subject = options.subject,
                     .kind = "accuracy_report",
                     .wait = options.wait,
                     .out = options.out};
    for (const std::string& text : options.requirements) parse_requirement(text);
    if (!options.requirements.empty()) wanted.options["require"] = options.requirements;
    if (!options.lever_arm.empty()) wanted.options["lever_arm"] = options.lever_arm;
    if (!options.time_offset.empty()) wanted.options["time_offset"] = options.time_offset;
    for (const auto& [kind, file] : {std::pair{"ground_truth", options.ground_truth},
                                     std::pair{"reference", options.reference},
                                     std::pair{"measurements", options.measurements},
                                     std::pair{"areas", options.areas}})
        if (!file.empty()) wanted.truth[kind] = {file, kind, options.subject};
    api::client::RestClient rest(account_of(options.server));
    return run_on_server(rest, wanted, context, [&](const std::string& artifacts) {
        if (!options.junit.empty())
            write_text(options.junit, rest.get_text(artifacts + "junit.xml"));
        return finish(rest.get(artifacts + "report.json"), context);
    });
}

}  // namespace

void add_report(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand(
        "report", "report how accurate a reconstruction is, and check requirements");
    auto options = std::make_shared<ReportOptions>();
    command
        ->add_option("reconstruction",
                     options->subject,
                     "folder of a reconstruction; with --server, id of a dive or job")
        ->required();
    add_server_options(*command, options->server);
    add_give_up_after(*command, options->server);
    command->add_flag(
        "--wait,!--no-wait", options->wait, "with --server: wait until it is done (default)");
    command->add_option("--dive", options->dive, "the dive, for its rig and its own ground truth");
    command->add_option(
        "--ground-truth", options->ground_truth, "true trajectory: TUM, EuRoC or KITTI");
    command->add_option(
        "--reference", options->reference, "true surface, mesh or points: PLY, OBJ or GLB");
    command->add_option("--measurements",
                        options->measurements,
                        "known lengths, in the format of measurements.json");
    command->add_option("--areas", options->areas, "areas to measure, in the format of areas.json");
    command->add_option(
        "--lever-arm",
        options->lever_arm,
        "pose of the truth's marker on the rig's body: x,y,z[,qw,qx,qy,qz] in m, or solve");
    command->add_option(
        "--time-offset", options->time_offset, "the truth's clock minus the dive's, s, or solve");
    command
        ->add_option(
            "--require",
            options->requirements,
            "metric, comparison (<= >= < >), number: 'drift_percent<=0.5'; may be repeated")
        ->allow_extra_args(false);
    command->add_option(
        "--out", options->out, "output folder; default: accuracy/ in the reconstruction's folder");
    command->add_option(
        "--junit", options->junit, "also write the verdicts to this file as JUnit XML");
    command->add_option(
        "--threads", options->num_threads, "0: all cores; the result does not depend on it");
    command->callback([options, &context, command] {
        const bool there = is_on_server(*command, options->subject);
        context.command = [options, &context, there] {
            return there ? report_there(*options, context) : report_here(*options, context);
        };
    });
}

}  // namespace divemesh::cli
