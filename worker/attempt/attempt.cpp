#include "worker/attempt/attempt.hpp"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <unistd.h>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "schemas/metric.hpp"
#include "schemas/reconstruction_options.hpp"
#include "schemas/truth_file.hpp"
#include "schemas/verdict.hpp"
#include "worker/attempt/attempt_protocol.hpp"
#include "worker/attempt/forbid_processes.hpp"
#include "worker/compare/compare.hpp"
#include "worker/pipeline/examine.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/report/accuracy_report.hpp"
#include "worker/report/truth_check.hpp"

namespace divemesh::attempt {
namespace {

using namespace std::chrono_literals;
constexpr auto kReportInterval = 250ms;

std::atomic<bool> cancel_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void request_cancel(int) { cancel_requested = true; }

// If the parent has ended, SIGPIPE is ignored and write() fails: the result is not needed any more.
void send(const AttemptMessage& message) {
    const std::string line = encode_message(message);
    for (std::size_t sent = 0; sent < line.size();) {
        const auto n = ::write(kAttemptPipe, line.data() + sent, line.size() - sent);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
            throw Error(ErrorCode::Cancelled, "the worker that started this attempt has ended");
        sent += static_cast<std::size_t>(n);
    }
}

AttemptRequest read_request(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream) throw Error(ErrorCode::NotFound, "there is no request file " + file.string());
    return nlohmann::json::parse(stream).get<AttemptRequest>();
}

base::ProgressCallback reporter() {
    return [last = std::chrono::steady_clock::time_point{},
            stage = std::string()](const Progress& progress) mutable {
        if (cancel_requested) throw Error(ErrorCode::Cancelled, "cancelled");
        const auto now = std::chrono::steady_clock::now();
        if (now - last < kReportInterval && progress.stage == stage) return;
        if (progress.stage != stage) send(LogText{"stage " + progress.stage + "\n"});
        last = now;
        stage = progress.stage;
        send(progress);
    };
}

void write_thumbnail(const std::filesystem::path& file, const std::string& jpeg) {
    std::ofstream stream(file, std::ios::binary);
    stream.write(jpeg.data(), static_cast<std::streamsize>(jpeg.size()));
    stream.close();
    if (!stream) throw Error(ErrorCode::OutOfSpace, "cannot write " + file.string());
}

std::optional<DivePosition> position_of(const dive::IntakeReport& report) {
    if (!report.position) return std::nullopt;
    return DivePosition{report.position->latitude_deg, report.position->longitude_deg};
}

void run_intake(const AttemptRequest& request) {
    const auto report = pipeline::examine(request.dive, request.scratch, reporter());
    if (!report.thumbnail_jpeg.empty())
        write_thumbnail(request.out / "thumbnail.jpg", report.thumbnail_jpeg);
    send(IntakeAnswer{.findings = report.findings,
                      .name = report.name,
                      .site = report.site,
                      .rig = report.rig,
                      .tags = report.tags,
                      .notes = report.notes,
                      .position = position_of(report),
                      .content_sha256 = report.content_sha256,
                      .num_frames = report.num_frames,
                      .duration_s = report.duration_s,
                      .has_thumbnail = !report.thumbnail_jpeg.empty()});
}

std::string text_at(const nlohmann::json& document, const char* pointer) {
    return document.value(nlohmann::json::json_pointer(pointer), std::string());
}

std::vector<MeasuredMetric> measured_metrics(const nlohmann::json& document) {
    std::vector<MeasuredMetric> metrics;
    for (const Metric& metric : flatten_metrics(document))
        if (metric.value)
            metrics.push_back({metric.name, *metric.value, metric.unit, metric.method});
    return metrics;
}

// Returns the metrics of a report, for the catalog.
Measurement measurement_of(const nlohmann::json& report) {
    Measurement measured;
    for (const auto& metric : report.at("figures"))
        if (metric.at("value").is_number())
            measured.metrics.push_back({metric.at("figure").get<std::string>(),
                                        metric.at("value").get<double>(),
                                        metric.at("unit").get<std::string>(),
                                        metric.at("method").get<std::string>()});
    report.at("requirements").get_to(measured.requirements);
    report.at("regressions").get_to(measured.regressions);
    measured.version = text_at(report, "/version");
    measured.calibration_sha256 = text_at(report, "/reconstruction/calibration_sha256");
    return measured;
}

std::optional<std::filesystem::path> truth_file(const AttemptRequest& request,
                                                std::string_view option) {
    const auto file = request.truth.find(std::string(option));
    if (file == request.truth.end()) return std::nullopt;
    return file->second;
}

std::optional<std::filesystem::path> truth_file(const AttemptRequest& request, TruthKind kind) {
    return truth_file(request, to_string(kind));
}

std::optional<UnreadableTruth> unreadable_truth(const AttemptRequest& request) {
    for (const auto& [kind, file] : request.truth) {
        const TruthKind of = truth_kind_from_string(kind);
        if (auto problem = report::problem_of_truth(of, file); !problem.empty())
            return UnreadableTruth{of, std::move(problem)};
    }
    return std::nullopt;
}

void run_report(const AttemptRequest& request) {
    const nlohmann::json& options = request.options;
    report::AccuracyReportRequest report{
        .reconstruction = request.reconstructions.at(0),
        .dive = request.dive,
        .out = request.out,
        .scratch = request.scratch,
        .ground_truth = truth_file(request, TruthKind::GroundTruth),
        .reference = truth_file(request, TruthKind::Reference),
        .measurements = truth_file(request, TruthKind::Measurements),
        .areas = truth_file(request, TruthKind::Areas),
        .requirements = options.value("require", std::vector<std::string>()),
        .history = request.history,
        .findings = request.findings,
        .num_threads = options.value("num_threads", 0)};
    if (options.contains("lever_arm"))
        set_lever_arm(report.truth, options["lever_arm"].get<std::string>());
    if (options.contains("time_offset"))
        set_time_offset(report.truth, options["time_offset"].get<std::string>());
    try {
        send(measurement_of(report::make_accuracy_report(report, reporter())));
    } catch (const Error& error) {
        const auto unreadable = unreadable_truth(request);
        if (error.code() == ErrorCode::Cancelled || !unreadable) throw;
        send(*unreadable);
        return send(Failure{.code = ErrorCode::BadData,
                            .message = unreadable->problem,
                            .remedy = "correct that file, send it again and create a new report"});
    }
    send(Done{});
}

void run_comparison(const AttemptRequest& request) {
    compare::CompareRequest compare{.a = request.reconstructions.at(0),
                                    .b = request.reconstructions.at(1),
                                    .out = request.out,
                                    .areas = truth_file(request, TruthKind::Areas),
                                    .later_areas = truth_file(request, "later_areas"),
                                    .num_threads = request.options.value("num_threads", 0)};
    compare::CompareOptions& options = compare.options;
    for (const auto& [name, value] : {std::pair{"cell_m", &options.cell_m},
                                      std::pair{"normal_scale_m", &options.normal_scale_m},
                                      std::pair{"cylinder_m", &options.cylinder_m},
                                      std::pair{"reach_m", &options.reach_m},
                                      std::pair{"least_area_m2", &options.least_area_m2}})
        *value = request.options.value(name, *value);
    try {
        compare::compare_reconstructions(compare, reporter());
    } catch (const Error& error) {
        if (error.code() != ErrorCode::Conflict) throw;
        return send(Failure{.code = ErrorCode::BadData,  // a retry cannot succeed
                            .message = error.what(),
                            .remedy = "compare dives that show the same ground"});
    }
    send(Done{});
}

std::string log_line(const Finding& finding) {
    return std::string(to_string(finding.severity)) + " " + finding.code + ": " +
           (finding.where.empty() ? "" : finding.where + ": ") + finding.message + "\n";
}

void run_reconstruction(const AttemptRequest& request) {
    const auto metrics =
        pipeline::reconstruct_dive({.dive = request.dive,
                                    .out = request.out,
                                    .scratch = request.scratch,
                                    .cache = request.cache,
                                    .cache_bytes = request.cache_bytes,
                                    .preset = request.preset,
                                    .options = make_options(request.preset, request.options),
                                    .stage_done = [](const StageRun& stage) { send(stage); }},
                                   reporter());
    const auto findings =
        metrics.value("findings", nlohmann::json::array()).get<std::vector<Finding>>();
    for (const Finding& finding : findings) send(LogText{log_line(finding)});
    send(Measurement{.metrics = measured_metrics(metrics),
                     .version = text_at(metrics, "/version"),
                     .calibration_sha256 = text_at(metrics, "/calibration/sha256"),
                     .findings = findings,
                     .verdict = verdict_on(findings)});
    if (const auto error = first_error(findings))
        return send(Failure{.code = ErrorCode::BadData,
                            .message = error->message +
                                       ": what was made of the dive until then is among the "
                                       "artifacts of the job",
                            .remedy = error->remedy});
    send(Done{});
}

void run(const AttemptRequest& request) {
    switch (request.kind) {
        case JobKind::Intake: return run_intake(request);
        case JobKind::Reconstruct: return run_reconstruction(request);
        case JobKind::AccuracyReport: return run_report(request);
        case JobKind::Compare: return run_comparison(request);
    }
}

}  // namespace

int run_attempt(const std::filesystem::path& request_file) try {
    std::signal(SIGTERM, request_cancel);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // at the quota write() fails instead of ending the process
    try {
        if (!forbid_processes())
            send(LogText{"this kernel cannot forbid the attempt to start processes\n"});
        run(read_request(request_file));
        return 0;
    } catch (const Error& error) {
        send(Failure{.code = error.code(), .message = error.what()});
    } catch (const std::bad_alloc&) {
        send(Failure{.code = ErrorCode::OutOfMemory, .message = "the attempt ran out of memory"});
    } catch (const std::exception& error) {
        send(Failure{.code = ErrorCode::Unavailable,
                     .message = std::string("internal error: ") + error.what(),
                     .remedy = "if it happens again, report it together with this dive"});
    }
    return 1;
} catch (...) {  // no parent to report to
    return 1;
}

}  // namespace divemesh::attempt
