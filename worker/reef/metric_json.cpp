#include "worker/reef/metric_json.hpp"

#include <algorithm>

namespace divemesh::reef {
namespace {

nlohmann::json entry(const AreaTask& task, const MetricKind& kind) {
    nlohmann::json json = {{"figure", kind.metric}, {"area", task.name}, {"unit", kind.unit}};
    if (!task.label.empty()) json["label"] = task.label;
    if (kind.resolution_m) json["resolution_m"] = *kind.resolution_m;
    return json;
}

}  // namespace

nlohmann::json metric_json(const AreaTask& task,
                           const MetricKind& kind,
                           const stats::Estimate& estimate) {
    nlohmann::json json = entry(task, kind);
    json["value"] = std::clamp(estimate.value, kind.lowest, kind.highest);
    json["low"] = std::clamp(estimate.low, kind.lowest, kind.highest);
    json["high"] = std::clamp(estimate.high, kind.lowest, kind.highest);
    json["method"] = kind.method;
    return json;
}

nlohmann::json refused_json(const AreaTask& task,
                            const MetricKind& kind,
                            const std::string& reason) {
    nlohmann::json json = entry(task, kind);
    json["refused"] = reason;
    return json;
}

}  // namespace divemesh::reef
