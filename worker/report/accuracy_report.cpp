#include "worker/report/accuracy_report.hpp"

#include <utility>

#include "schemas/json.hpp"
#include "schemas/metric.hpp"
#include "schemas/requirement.hpp"
#include "schemas/verdict.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/report/report_formats.hpp"
#include "worker/report/report_inputs.hpp"
#include "worker/report/report_measurements.hpp"
#include "worker/report/report_page.hpp"
#include "worker/report/report_reef.hpp"
#include "worker/report/report_verdicts.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

json to_json(const Metric& metric) {
    return {{"figure", metric.name},
            {"value", metric.value ? json(*metric.value) : json()},
            {"unit", metric.unit},
            {"method", metric.method},
            {"alignment", metric.alignment}};
}

std::string text_at(const json& document, const char* pointer) {
    return document.value(json::json_pointer(pointer), std::string());
}

// Returns "reconstruction" of report.json: the verdict and the findings as metrics.json states
// them.
json reconstruction_section(const io::ReconstructionFolder& reconstruction) {
    const json& metrics = reconstruction.metrics();
    json section = {{"version", text_at(metrics, "/version")},
                    {"preset", text_at(metrics, "/preset")},
                    {"calibration_sha256", text_at(metrics, "/calibration/sha256")},
                    {"findings", reconstruction.findings()}};
    const auto verdict = reconstruction.verdict();
    if (!verdict) return section;
    section["verdict"] = to_string(*verdict);
    section["restrictions"] = reconstruction.restrictions();
    return section;
}

// Returns why no requirement on this result is met; "" if it is usable.
std::string reason_against(const io::ReconstructionFolder& reconstruction) {
    const auto error = first_error(reconstruction.findings());
    if (!error && reconstruction.verdict() != Verdict::NotUsable) return "";
    return "the reconstruction is not usable" +
           (error ? " (" + error->code + "): " + error->message : std::string());
}

json report_document(const AccuracyReportRequest& request,
                     const std::vector<Requirement>& requirements,
                     const ReportInputs& inputs,
                     const ReportMeasurements& measured) {
    const json& metrics = measured.document;
    std::vector<Metric> flattened = flatten_metrics(metrics);
    for (Metric& metric : reef_metrics(measured.reef)) flattened.push_back(std::move(metric));
    for (Metric& metric : flattened)
        if (!metric.value && metric.name.ends_with(".drift_percent"))
            metric.method = "refused: the path is shorter than the shortest segment";
    json report = {
        {"format", 1},
        {"version", DIVEMESH_VERSION},
        {"dive",
         {{"name", text_at(metrics, "/dive/name")},
          {"content_sha256", text_at(metrics, "/dive/content_sha256")}}},
        {"reconstruction", reconstruction_section(inputs.reconstruction)},
        {"files", inputs.files},
        {"figures", json::array()},
        {"requirements",
         judge_requirements(requirements, flattened, reason_against(inputs.reconstruction))},
        {"regressions", find_regressions(request.history, flattened)},
        {"findings", measured.findings}};
    for (const Metric& metric : flattened) report["figures"].push_back(to_json(metric));
    report["passed"] = passed(report["requirements"]);
    if (!measured.reef.is_null()) report["reef"] = measured.reef;
    if (!metrics.contains("truth")) return report;
    report["truth"] = metrics["truth"];
    report["truth"]["source"] = inputs.truth_source;
    report["truth"]["format"] = to_string(inputs.truth->format);
    return report;
}

}  // namespace

json make_accuracy_report(const AccuracyReportRequest& request,
                          const base::ProgressCallback& progress) {
    std::vector<Requirement> requirements;
    for (const std::string& text : request.requirements)
        requirements.push_back(parse_requirement(text));
    const ReportInputs inputs = read_report_inputs(request, progress);
    const ReportMeasurements measured = measure_for_report(inputs, request, progress);
    json report = report_document(request, requirements, inputs, measured);
    std::filesystem::create_directories(request.out);
    // A name in a dive may be invalid UTF-8, which must not fail the report.
    const auto replace = json::error_handler_t::replace;
    base::write_file(request.out / "report.json", report.dump(2, ' ', false, replace) + "\n");
    base::write_file(request.out / "report.csv", report_csv(report));
    base::write_file(request.out / "junit.xml", report_junit(report));
    base::write_file(request.out / "report.html", report_page(report, measured));
    progress({.stage = "evaluate", .fraction = 1.0});
    return report;
}

}  // namespace divemesh::report
