#include "schemas/json.hpp"

namespace divemesh {

void to_json(nlohmann::json& json, const Finding& finding) {
    json = {{"severity", to_string(finding.severity)},
            {"code", finding.code},
            {"where", finding.where},
            {"message", finding.message},
            {"remedy", finding.remedy}};
}

void from_json(const nlohmann::json& json, Finding& finding) {
    finding.severity = severity_from_string(json.at("severity").get<std::string>());
    json.at("code").get_to(finding.code);
    json.at("where").get_to(finding.where);
    json.at("message").get_to(finding.message);
    json.at("remedy").get_to(finding.remedy);
}

void to_json(nlohmann::json& json, const Dive& dive) {
    json = {{"id", dive.id},
            {"project", dive.project},
            {"state", to_string(dive.state)},
            {"name", dive.name},
            {"site", dive.site},
            {"tags", dive.tags},
            {"archive_sha256", dive.archive_sha256},
            {"content_sha256", dive.content_sha256},
            {"archive_bytes", dive.archive_bytes},
            {"num_frames", dive.num_frames},
            {"duration_s", dive.duration_s},
            {"has_thumbnail", dive.has_thumbnail},
            {"created_at_ms", dive.created_at_ms}};
}

void from_json(const nlohmann::json& json, Dive& dive) {
    json.at("id").get_to(dive.id);
    json.at("project").get_to(dive.project);
    dive.state = dive_state_from_string(json.at("state").get<std::string>());
    json.at("name").get_to(dive.name);
    json.at("site").get_to(dive.site);
    json.at("tags").get_to(dive.tags);
    json.at("archive_sha256").get_to(dive.archive_sha256);
    json.at("content_sha256").get_to(dive.content_sha256);
    json.at("archive_bytes").get_to(dive.archive_bytes);
    json.at("num_frames").get_to(dive.num_frames);
    json.at("duration_s").get_to(dive.duration_s);
    json.at("has_thumbnail").get_to(dive.has_thumbnail);
    json.at("created_at_ms").get_to(dive.created_at_ms);
}

void to_json(nlohmann::json& json, const Upload& upload) {
    json = {{"id", upload.id},
            {"project", upload.project},
            {"length_bytes", upload.length_bytes},
            {"offset_bytes", upload.offset_bytes},
            {"metadata", upload.metadata},
            {"dive_id", upload.dive_id},
            {"created_at_ms", upload.created_at_ms}};
}

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
    json = {{"code", to_string(failure.code)}, {"message", failure.message}};
}

void from_json(const nlohmann::json& json, Failure& failure) {
    failure.code = error_code_from_string(json.at("code").get<std::string>());
    json.at("message").get_to(failure.message);
}

void to_json(nlohmann::json& json, const Job& job) {
    json = {{"id", job.id},
            {"project", job.project},
            {"dive_id", job.dive_id},
            {"kind", to_string(job.kind)},
            {"state", to_string(job.state)},
            {"preset", job.preset},
            {"options", job.options},
            {"priority", job.priority},
            {"num_attempts", job.num_attempts},
            {"max_attempts", job.max_attempts},
            {"cancel_requested", job.cancel_requested},
            {"progress", job.progress},
            {"failure", nullptr},
            {"not_before_ms", job.not_before_ms},
            {"created_at_ms", job.created_at_ms},
            {"started_at_ms", job.started_at_ms},
            {"finished_at_ms", job.finished_at_ms}};
    if (!job.failure.message.empty()) json["failure"] = job.failure;
}

void from_json(const nlohmann::json& json, Job& job) {
    json.at("id").get_to(job.id);
    json.at("project").get_to(job.project);
    json.at("dive_id").get_to(job.dive_id);
    job.kind = job_kind_from_string(json.at("kind").get<std::string>());
    job.state = job_state_from_string(json.at("state").get<std::string>());
    json.at("preset").get_to(job.preset);
    job.options = json.at("options");
    json.at("priority").get_to(job.priority);
    json.at("num_attempts").get_to(job.num_attempts);
    json.at("max_attempts").get_to(job.max_attempts);
    json.at("cancel_requested").get_to(job.cancel_requested);
    json.at("progress").get_to(job.progress);
    job.failure = json.at("failure").is_null() ? Failure{} : json.at("failure").get<Failure>();
    json.at("not_before_ms").get_to(job.not_before_ms);
    json.at("created_at_ms").get_to(job.created_at_ms);
    json.at("started_at_ms").get_to(job.started_at_ms);
    json.at("finished_at_ms").get_to(job.finished_at_ms);
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

void to_json(nlohmann::json& json, const Artifact& artifact) {
    json = {{"job_id", artifact.job_id},
            {"name", artifact.name},
            {"media_type", artifact.media_type},
            {"sha256", artifact.sha256},
            {"size_bytes", artifact.size_bytes}};
}

void from_json(const nlohmann::json& json, Artifact& artifact) {
    json.at("job_id").get_to(artifact.job_id);
    json.at("name").get_to(artifact.name);
    json.at("media_type").get_to(artifact.media_type);
    json.at("sha256").get_to(artifact.sha256);
    json.at("size_bytes").get_to(artifact.size_bytes);
}

void to_json(nlohmann::json& json, const Event& event) {
    json = {{"sequence", event.sequence},
            {"time_ms", event.time_ms},
            {"project", event.project},
            {"topic", event.topic},
            {"subject", event.subject},
            {"type", event.type},
            {"data", event.data}};
}

void from_json(const nlohmann::json& json, Event& event) {
    json.at("sequence").get_to(event.sequence);
    json.at("time_ms").get_to(event.time_ms);
    json.at("project").get_to(event.project);
    json.at("topic").get_to(event.topic);
    json.at("subject").get_to(event.subject);
    json.at("type").get_to(event.type);
    event.data = json.at("data");
}

void to_json(nlohmann::json& json, const Token& token) {
    json = {{"id", token.id},
            {"name", token.name},
            {"project", token.project},
            {"scopes", token.scopes},
            {"created_at_ms", token.created_at_ms},
            {"last_used_at_ms", token.last_used_at_ms},
            {"revoked", token.revoked}};
}

}  // namespace divemesh
