// The JSON of metrics, and of the truth and the schedules that belong to them.
#include "schemas/json.hpp"

namespace divemesh {

void to_json(nlohmann::json& json, const TruthFile& truth) {
    json = {{"id", truth.id},
            {"project", truth.project},
            {"dive_id", truth.dive_id},
            {"kind", to_string(truth.kind)},
            {"name", truth.name},
            {"sha256", truth.sha256},
            {"size_bytes", truth.size_bytes},
            {"created_at_ms", truth.created_at_ms},
            {"problem", truth.problem}};
}

void from_json(const nlohmann::json& json, TruthFile& truth) {
    json.at("id").get_to(truth.id);
    json.at("project").get_to(truth.project);
    json.at("dive_id").get_to(truth.dive_id);
    truth.kind = truth_kind_from_string(json.at("kind").get<std::string>());
    json.at("name").get_to(truth.name);
    json.at("sha256").get_to(truth.sha256);
    json.at("size_bytes").get_to(truth.size_bytes);
    json.at("created_at_ms").get_to(truth.created_at_ms);
    truth.problem = json.value("problem", "");
}

void to_json(nlohmann::json& json, const MeasuredMetric& metric) {
    json = {{"name", metric.name},
            {"value", metric.value},
            {"unit", metric.unit},
            {"method", metric.method}};
}

void from_json(const nlohmann::json& json, MeasuredMetric& metric) {
    json.at("name").get_to(metric.name);
    json.at("value").get_to(metric.value);
    json.at("unit").get_to(metric.unit);
    json.at("method").get_to(metric.method);
}

void to_json(nlohmann::json& json, const RequirementResult& result) {
    json = {{"text", result.text},
            {"figure", result.metric},
            {"value", nullptr},
            {"met", result.met},
            {"reason", result.reason}};
    if (result.value) json["value"] = *result.value;
}

void from_json(const nlohmann::json& json, RequirementResult& result) {
    json.at("text").get_to(result.text);
    json.at("figure").get_to(result.metric);
    result.value.reset();
    if (!json.at("value").is_null()) result.value = json.at("value").get<double>();
    json.at("met").get_to(result.met);
    json.at("reason").get_to(result.reason);
}

void to_json(nlohmann::json& json, const Regression& regression) {
    json = {{"figure", regression.metric},
            {"value", regression.value},
            {"median", regression.median},
            {"limit", regression.limit},
            {"num_earlier", regression.num_earlier}};
}

void from_json(const nlohmann::json& json, Regression& regression) {
    json.at("figure").get_to(regression.metric);
    json.at("value").get_to(regression.value);
    json.at("median").get_to(regression.median);
    json.at("limit").get_to(regression.limit);
    json.at("num_earlier").get_to(regression.num_earlier);
}

void to_json(nlohmann::json& json, const Measurement& measured) {
    json = {{"figures", measured.metrics},
            {"requirements", measured.requirements},
            {"regressions", measured.regressions},
            {"version", measured.version},
            {"calibration_sha256", measured.calibration_sha256},
            {"findings", measured.findings},
            {"verdict", nullptr}};
    if (measured.verdict) json["verdict"] = to_string(*measured.verdict);
}

void from_json(const nlohmann::json& json, Measurement& measured) {
    json.at("figures").get_to(measured.metrics);
    json.at("requirements").get_to(measured.requirements);
    json.at("regressions").get_to(measured.regressions);
    json.at("version").get_to(measured.version);
    json.at("calibration_sha256").get_to(measured.calibration_sha256);
    json.at("findings").get_to(measured.findings);
    measured.verdict.reset();
    if (!json.at("verdict").is_null())
        measured.verdict = verdict_from_string(json.at("verdict").get<std::string>());
}

void to_json(nlohmann::json& json, const MetricPoint& point) {
    json = {{"dive_id", point.dive_id},
            {"job_id", point.job_id},
            {"kind", point.kind},
            {"site", point.site},
            {"rig", point.rig},
            {"preset", point.preset},
            {"version", point.version},
            {"calibration_sha256", point.calibration_sha256},
            {"time_ms", point.time_ms},
            {"value", point.value}};
}

void to_json(nlohmann::json& json, const Schedule& schedule) {
    json = {{"id", schedule.id},
            {"project", schedule.project},
            {"cron", schedule.cron},
            {"tag", schedule.tag},
            {"preset", schedule.preset},
            {"options", schedule.options},
            {"created_at_ms", schedule.created_at_ms},
            {"next_run_ms", schedule.next_run_ms},
            {"last_run_ms", schedule.last_run_ms},
            {"last_num_jobs", schedule.last_num_jobs},
            {"last_problem", schedule.last_problem}};
}

void from_json(const nlohmann::json& json, Schedule& schedule) {
    json.at("id").get_to(schedule.id);
    json.at("project").get_to(schedule.project);
    json.at("cron").get_to(schedule.cron);
    json.at("tag").get_to(schedule.tag);
    json.at("preset").get_to(schedule.preset);
    schedule.options = json.at("options");
    json.at("created_at_ms").get_to(schedule.created_at_ms);
    json.at("next_run_ms").get_to(schedule.next_run_ms);
    json.at("last_run_ms").get_to(schedule.last_run_ms);
    json.at("last_num_jobs").get_to(schedule.last_num_jobs);
    json.at("last_problem").get_to(schedule.last_problem);
}

}  // namespace divemesh
