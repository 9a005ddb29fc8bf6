// The JSON of jobs and their attempts, of the queue and of workers.
#include "schemas/json.hpp"
#include "schemas/shown_job.hpp"

namespace divemesh {

void to_json(nlohmann::json& json, const Progress& progress) {
    json = {{"stage", progress.stage},
            {"fraction", progress.fraction},
            {"frames_done", progress.frames_done},
            {"num_frames", progress.num_frames},
            {"frames_per_s", progress.frames_per_s},
            {"seconds_left", progress.seconds_left}};
}

void from_json(const nlohmann::json& json, Progress& progress) {
    json.at("stage").get_to(progress.stage);
    json.at("fraction").get_to(progress.fraction);
    json.at("frames_done").get_to(progress.frames_done);
    json.at("num_frames").get_to(progress.num_frames);
    json.at("frames_per_s").get_to(progress.frames_per_s);
    json.at("seconds_left").get_to(progress.seconds_left);
}

void to_json(nlohmann::json& json, const Failure& failure) {
    json = {{"code", to_string(failure.code)},
            {"message", failure.message},
            {"remedy", failure.remedy.empty() ? usual_remedy(failure.code) : failure.remedy}};
}

void from_json(const nlohmann::json& json, Failure& failure) {
    failure.code = error_code_from_string(json.at("code").get<std::string>());
    json.at("message").get_to(failure.message);
    json.at("remedy").get_to(failure.remedy);
}

void to_json(nlohmann::json& json, const StageRun& stage) {
    json = {{"name", stage.name}, {"seconds", stage.seconds}, {"from_cache", stage.from_cache}};
}

void from_json(const nlohmann::json& json, StageRun& stage) {
    json.at("name").get_to(stage.name);
    json.at("seconds").get_to(stage.seconds);
    json.at("from_cache").get_to(stage.from_cache);
}

void to_json(nlohmann::json& json, const Forecast& forecast) {
    json = {{"position", forecast.position}};
    if (forecast.starts_in_s >= 0.0) json["starts_in_s"] = forecast.starts_in_s;
    if (forecast.takes_s >= 0.0) json["takes_s"] = forecast.takes_s;
}

void from_json(const nlohmann::json& json, Forecast& forecast) {
    json.at("position").get_to(forecast.position);
    forecast.starts_in_s = json.value("starts_in_s", -1.0);
    forecast.takes_s = json.value("takes_s", -1.0);
}

void to_json(nlohmann::json& json, const Job& job) {
    json = {{"id", job.id},
            {"project", job.project},
            {"dive_id", job.dive_id},
            {"kind", to_string(job.kind)},
            {"state", to_string(job.state)},
            {"preset", job.preset},
            {"options", job.options},
            {"parents", job.parents},
            {"priority", job.priority},
            {"paused", job.paused},
            {"lowered", job.lowered},
            {"num_attempts", job.num_attempts},
            {"max_attempts", job.max_attempts},
            {"cancel_requested", job.cancel_requested},
            {"progress", job.progress},
            {"stages", job.stages},
            {"forecast", nullptr},
            {"failure", nullptr},
            {"verdict", nullptr},
            {"requirements", job.requirements},
            {"findings", job.findings},
            {"not_before_ms", job.not_before_ms},
            {"created_at_ms", job.created_at_ms},
            {"started_at_ms", job.started_at_ms},
            {"finished_at_ms", job.finished_at_ms}};
    if (!job.failure.message.empty()) json["failure"] = job.failure;
    if (job.forecast) json["forecast"] = *job.forecast;
    if (const auto verdict = verdict_of(job); !verdict.empty()) json["verdict"] = verdict;
}

void from_json(const nlohmann::json& json, Job& job) {
    json.at("id").get_to(job.id);
    json.at("project").get_to(job.project);
    json.at("dive_id").get_to(job.dive_id);
    job.kind = job_kind_from_string(json.at("kind").get<std::string>());
    job.state = job_state_from_string(json.at("state").get<std::string>());
    json.at("preset").get_to(job.preset);
    job.options = json.at("options");
    json.at("parents").get_to(job.parents);
    json.at("priority").get_to(job.priority);
    json.at("paused").get_to(job.paused);
    json.at("lowered").get_to(job.lowered);
    json.at("num_attempts").get_to(job.num_attempts);
    json.at("max_attempts").get_to(job.max_attempts);
    json.at("cancel_requested").get_to(job.cancel_requested);
    json.at("progress").get_to(job.progress);
    json.at("stages").get_to(job.stages);
    if (!json.at("forecast").is_null()) job.forecast = json.at("forecast").get<Forecast>();
    job.failure = json.at("failure").is_null() ? Failure{} : json.at("failure").get<Failure>();
    json.at("requirements").get_to(job.requirements);
    // Older servers state neither verdict nor findings.
    if (const auto verdict = json.find("verdict");
        job.kind == JobKind::Reconstruct && verdict != json.end() && !verdict->is_null())
        job.verdict = verdict_from_string(verdict->get<std::string>());
    job.findings = json.value("findings", std::vector<Finding>());
    json.at("not_before_ms").get_to(job.not_before_ms);
    json.at("created_at_ms").get_to(job.created_at_ms);
    json.at("started_at_ms").get_to(job.started_at_ms);
    json.at("finished_at_ms").get_to(job.finished_at_ms);
}

void to_json(nlohmann::json& json, const ShownJob& job) {
    json = static_cast<const Job&>(job);
    if (!job.waits_for.empty()) json["waits_for"] = job.waits_for;
    if (job.deleted_at_ms == 0) return;
    json["deleted_at_ms"] = job.deleted_at_ms;
    json["expires_at_ms"] = job.expires_at_ms;
}

void from_json(const nlohmann::json& json, ShownJob& job) {
    json.get_to(static_cast<Job&>(job));
    job.waits_for = json.value("waits_for", "");
    job.deleted_at_ms = json.value("deleted_at_ms", std::int64_t{0});
    job.expires_at_ms = json.value("expires_at_ms", std::int64_t{0});
}

void to_json(nlohmann::json& json, const Attempt& attempt) {
    json = {{"job_id", attempt.job_id},
            {"number", attempt.number},
            {"state", to_string(attempt.state)},
            {"worker", attempt.worker},
            {"failure", nullptr},
            {"started_at_ms", attempt.started_at_ms},
            {"finished_at_ms", attempt.finished_at_ms}};
    if (!attempt.failure.message.empty()) json["failure"] = attempt.failure;
}

void from_json(const nlohmann::json& json, Attempt& attempt) {
    json.at("job_id").get_to(attempt.job_id);
    json.at("number").get_to(attempt.number);
    attempt.state = attempt_state_from_string(json.at("state").get<std::string>());
    json.at("worker").get_to(attempt.worker);
    attempt.failure = json.at("failure").is_null() ? Failure{} : json.at("failure").get<Failure>();
    json.at("started_at_ms").get_to(attempt.started_at_ms);
    json.at("finished_at_ms").get_to(attempt.finished_at_ms);
}

void to_json(nlohmann::json& json, const Queue& queue) {
    json = {{"project", queue.project},
            {"paused", queue.paused},
            {"max_running", queue.max_running},
            {"keep_results", queue.keep_results},
            {"num_jobs", queue.num_jobs}};
}

void from_json(const nlohmann::json& json, Queue& queue) {
    json.at("project").get_to(queue.project);
    json.at("paused").get_to(queue.paused);
    json.at("max_running").get_to(queue.max_running);
    queue.keep_results = json.value("keep_results", 0);  // older servers keep all
    json.at("num_jobs").get_to(queue.num_jobs);
}

void to_json(nlohmann::json& json, const Worker& worker) {
    json = {{"name", worker.name},
            {"num_slots", worker.num_slots},
            {"num_running", worker.num_running},
            {"draining", worker.draining},
            {"alive", worker.alive},
            {"started_at_ms", worker.started_at_ms},
            {"seen_at_ms", worker.seen_at_ms}};
    if (!worker.waits_for.empty()) json["waits_for"] = worker.waits_for;
}

void from_json(const nlohmann::json& json, Worker& worker) {
    json.at("name").get_to(worker.name);
    json.at("num_slots").get_to(worker.num_slots);
    json.at("num_running").get_to(worker.num_running);
    json.at("draining").get_to(worker.draining);
    json.at("alive").get_to(worker.alive);
    worker.waits_for = json.value("waits_for", "");
    json.at("started_at_ms").get_to(worker.started_at_ms);
    json.at("seen_at_ms").get_to(worker.seen_at_ms);
}

}  // namespace divemesh
