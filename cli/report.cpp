#include <algorithm>
#include <cstdio>
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
#include "cli/metrics_table.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scratch.hpp"
#include "cli/server_options.hpp"
#include "cli/text.hpp"
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

std::string value_text(const nlohmann::json& value) {
    if (!value.is_number()) return "-";
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value.get<double>());
    return text;
}

std::string unit_text(const nlohmann::json& metric) {
    const auto unit = metric.at("unit").get<std::string>();
    return unit == "1" || !metric.at("value").is_number() ? "" : " " + unit;
}

// Adds lever arm and time offset if they were solved.
void add_truth(const nlohmann::json& report, std::vector<std::vector<std::string>>& rows) {
    const nlohmann::json truth = report.value("truth", nlohmann::json::object());
    if (!truth.contains("num_poses")) return;
    const auto& offset = truth.at("time_offset_s");
    const auto& lever = truth.at("lever_arm_m");
    if (offset.contains("sigma"))
        rows.push_back({"",
                        "time offset of the truth",
                        value_text(offset.at("value")) + " s, sigma " +
                            value_text(offset.at("sigma")) + " s"});
    if (lever.contains("sigma"))
        for (std::size_t axis = 0; axis < 3; ++axis)
            rows.push_back({"",
                            std::string("lever arm of the truth, ") + "xyz"[axis],
                            value_text(lever.at("vector").at(axis)) + " m, sigma " +
                                value_text(lever.at("sigma").at(axis)) + " m"});
}

// Returns the verdicts, then the metrics that papers quote.
std::string summary(const nlohmann::json& report) {
    constexpr const char* kQuoted[] = {"trajectory.final.ate_rmse_m",
                                       "trajectory.final.drift_percent",
                                       "surface.accuracy.median_m",
                                       "surface.completeness.median_m",
                                       "known_distances.scale_error"};
    std::vector<std::vector<std::string>> rows;
    for (const auto& requirement : report.at("requirements"))
        rows.push_back({requirement.at("met").get<bool>() ? "met" : "NOT MET",
                        requirement.at("text").get<std::string>(),
                        requirement.at("reason").get<std::string>()});
    for (const auto& regression : report.at("regressions"))
        rows.push_back({"WORSE",
                        regression.at("figure").get<std::string>(),
                        value_text(regression.at("value")) + ", limit from its history " +
                            value_text(regression.at("limit"))});
    for (const auto& metric : report.at("figures"))
        if (std::find(std::begin(kQuoted),
                      std::end(kQuoted),
                      metric.at("figure").get<std::string>()) != std::end(kQuoted))
            rows.push_back({"",
                            metric.at("figure").get<std::string>(),
                            value_text(metric.at("value")) + unit_text(metric)});
    add_truth(report, rows);
    return table_text(rows);
}

int finish(const nlohmann::json& report, const Context& context) {
    for (const auto& finding : report.at("findings"))
        std::cerr << finding.at("severity").get<std::string>() << ": "
                  << finding.at("message").get<std::string>() << '\n';
    std::cout << (context.json ? report.dump(2) + "\n" : summary(report));
    return report.at("passed") == false ? kExitRequirementUnmet : kExitDone;
}

int report_here(const ReportOptions& options, const Context& context) {
    const fs::path folder = options.subject;
    report::AccuracyReportRequest request;
    request.reconstruction = folder;
    request.dive = given(options.dive);
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
