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

void to_json(nlohmann::json& json, const DivePosition& position) {
    json = {{"latitude_deg", position.latitude_deg}, {"longitude_deg", position.longitude_deg}};
}

void from_json(const nlohmann::json& json, DivePosition& position) {
    json.at("latitude_deg").get_to(position.latitude_deg);
    json.at("longitude_deg").get_to(position.longitude_deg);
}

void to_json(nlohmann::json& json, const Dive& dive) {
    json = {{"id", dive.id},
            {"project", dive.project},
            {"state", to_string(dive.state)},
            {"name", dive.name},
            {"site", dive.site},
            {"rig", dive.rig},
            {"tags", dive.tags},
            {"notes", dive.notes},
            {"position", nullptr},
            {"recorded", dive.recorded},
            {"archive_sha256", dive.archive_sha256},
            {"content_sha256", dive.content_sha256},
            {"archive_bytes", dive.archive_bytes},
            {"num_frames", dive.num_frames},
            {"duration_s", dive.duration_s},
            {"has_thumbnail", dive.has_thumbnail},
            {"created_at_ms", dive.created_at_ms},
            {"deleted_at_ms", dive.deleted_at_ms},
            {"expires_at_ms", dive.expires_at_ms}};
    if (dive.position) json["position"] = *dive.position;
}

void from_json(const nlohmann::json& json, Dive& dive) {
    json.at("id").get_to(dive.id);
    json.at("project").get_to(dive.project);
    dive.state = dive_state_from_string(json.at("state").get<std::string>());
    json.at("name").get_to(dive.name);
    json.at("site").get_to(dive.site);
    json.at("rig").get_to(dive.rig);
    json.at("tags").get_to(dive.tags);
    // Older servers do not send these.
    dive.notes = json.value("notes", "");
    if (json.contains("position") && !json["position"].is_null())
        dive.position = json["position"].get<DivePosition>();
    dive.recorded = json.value("recorded", nlohmann::json::object());
    json.at("archive_sha256").get_to(dive.archive_sha256);
    json.at("content_sha256").get_to(dive.content_sha256);
    json.at("archive_bytes").get_to(dive.archive_bytes);
    json.at("num_frames").get_to(dive.num_frames);
    json.at("duration_s").get_to(dive.duration_s);
    json.at("has_thumbnail").get_to(dive.has_thumbnail);
    json.at("created_at_ms").get_to(dive.created_at_ms);
    json.at("deleted_at_ms").get_to(dive.deleted_at_ms);
    json.at("expires_at_ms").get_to(dive.expires_at_ms);
}

void to_json(nlohmann::json& json, const Upload& upload) {
    json = {{"id", upload.id},
            {"project", upload.project},
            {"length_bytes", nullptr},
            {"offset_bytes", upload.offset_bytes},
            {"metadata", upload.metadata},
            {"concat", upload.concat},
            {"dive_id", upload.dive_id},
            {"truth_id", upload.truth_id},
            {"created_at_ms", upload.created_at_ms},
            {"expires_at_ms", upload.expires_at_ms}};
    if (upload.length_bytes) json["length_bytes"] = *upload.length_bytes;
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

void to_json(nlohmann::json& json, const KnownMetric& metric) {
    json = {{"name", metric.name},
            {"unit", metric.unit},
            {"better", to_string(metric.better)},
            {"method", metric.method}};
}

void to_json(nlohmann::json& json, const Token& token) {
    json = {{"id", token.id},
            {"name", token.name},
            {"project", token.project},
            {"scopes", token.scopes},
            {"sensor", token.sensor},
            {"shared_job", token.shared_job},
            {"created_at_ms", token.created_at_ms},
            {"last_used_at_ms", token.last_used_at_ms},
            {"expires_at_ms", token.expires_at_ms},
            {"revoked", token.revoked}};
}

void to_json(nlohmann::json& json, const Share& share) {
    json = {{"id", share.id},
            {"job_id", share.job_id},
            {"name", share.name},
            {"created_at_ms", share.created_at_ms},
            {"last_used_at_ms", share.last_used_at_ms},
            {"expires_at_ms", share.expires_at_ms},
            {"withdrawn", share.withdrawn}};
}

void to_json(nlohmann::json& json, const Webhook& webhook) {
    json = {{"id", webhook.id},
            {"project", webhook.project},
            {"url", webhook.url},
            {"topics", webhook.topics},
            {"enabled", webhook.enabled},
            {"created_at_ms", webhook.created_at_ms}};
}

void to_json(nlohmann::json& json, const WebhookDelivery& delivery) {
    json = {{"id", delivery.id},
            {"webhook_id", delivery.webhook_id},
            {"type", delivery.type},
            {"state", delivery.state},
            {"num_attempts", delivery.num_attempts},
            {"next_at_ms", delivery.next_at_ms},
            {"last_status", delivery.last_status},
            {"last_error", delivery.last_error},
            {"created_at_ms", delivery.created_at_ms},
            {"finished_at_ms", delivery.finished_at_ms}};
}

}  // namespace divemesh
