#pragma once

#include <nlohmann/json.hpp>

#include "schemas/artifact.hpp"
#include "schemas/dive.hpp"
#include "schemas/event.hpp"
#include "schemas/finding.hpp"
#include "schemas/job.hpp"
#include "schemas/known_metric.hpp"
#include "schemas/measurement.hpp"
#include "schemas/queue.hpp"
#include "schemas/schedule.hpp"
#include "schemas/share.hpp"
#include "schemas/token.hpp"
#include "schemas/truth_file.hpp"
#include "schemas/upload.hpp"
#include "schemas/webhook.hpp"
#include "schemas/worker.hpp"

// JSON of what crosses a process boundary, for server, CLI, worker and catalog. JSON keys are the
// field names; api/openapi.yaml documents them. from_json throws for a wrong type
// (nlohmann::json::exception) and for an unknown word (Error).
namespace divemesh {

void to_json(nlohmann::json& json, const Finding& finding);
void from_json(const nlohmann::json& json, Finding& finding);
void to_json(nlohmann::json& json, const DivePosition& position);
void from_json(const nlohmann::json& json, DivePosition& position);
void to_json(nlohmann::json& json, const Dive& dive);
void from_json(const nlohmann::json& json, Dive& dive);
void to_json(nlohmann::json& json, const Upload& upload);
void to_json(nlohmann::json& json, const Progress& progress);
void from_json(const nlohmann::json& json, Progress& progress);
void to_json(nlohmann::json& json, const Failure& failure);
void from_json(const nlohmann::json& json, Failure& failure);
void to_json(nlohmann::json& json, const Job& job);
void from_json(const nlohmann::json& json, Job& job);
void to_json(nlohmann::json& json, const StageRun& stage);
void from_json(const nlohmann::json& json, StageRun& stage);
void to_json(nlohmann::json& json, const Forecast& forecast);
void from_json(const nlohmann::json& json, Forecast& forecast);
void to_json(nlohmann::json& json, const Attempt& attempt);
void from_json(const nlohmann::json& json, Attempt& attempt);
void to_json(nlohmann::json& json, const Queue& queue);
void from_json(const nlohmann::json& json, Queue& queue);
void to_json(nlohmann::json& json, const Worker& worker);
void from_json(const nlohmann::json& json, Worker& worker);
void to_json(nlohmann::json& json, const TruthFile& truth);
void from_json(const nlohmann::json& json, TruthFile& truth);
void to_json(nlohmann::json& json, const MeasuredMetric& metric);
void from_json(const nlohmann::json& json, MeasuredMetric& metric);
void to_json(nlohmann::json& json, const RequirementResult& result);
void from_json(const nlohmann::json& json, RequirementResult& result);
void to_json(nlohmann::json& json, const Regression& regression);
void from_json(const nlohmann::json& json, Regression& regression);
void to_json(nlohmann::json& json, const Measurement& measured);
void from_json(const nlohmann::json& json, Measurement& measured);
void to_json(nlohmann::json& json, const MetricPoint& point);
void to_json(nlohmann::json& json, const KnownMetric& metric);
void to_json(nlohmann::json& json, const Schedule& schedule);
void from_json(const nlohmann::json& json, Schedule& schedule);
void to_json(nlohmann::json& json, const Artifact& artifact);
void from_json(const nlohmann::json& json, Artifact& artifact);
void to_json(nlohmann::json& json, const Event& event);
void from_json(const nlohmann::json& json, Event& event);
void to_json(nlohmann::json& json, const Share& share);
void to_json(nlohmann::json& json, const Token& token);      // never the hash
void to_json(nlohmann::json& json, const Webhook& webhook);  // never the secret
void to_json(nlohmann::json& json, const WebhookDelivery& delivery);

}  // namespace divemesh
