#include "worker/compare/change_figure.hpp"

namespace divemesh::worker {
namespace {

nlohmann::json entry(nlohmann::json whose, const ChangeFigure& figure) {
    whose["figure"] = figure.figure;
    whose["unit"] = figure.unit;
    if (figure.earlier) whose["earlier"] = estimate_json(*figure.earlier);
    if (figure.later) whose["later"] = estimate_json(*figure.later);
    return whose;
}

}  // namespace

nlohmann::json estimate_json(const Estimate& estimate) {
    return {{"value", estimate.value}, {"low", estimate.low}, {"high", estimate.high}};
}

nlohmann::json change_json(nlohmann::json whose,
                           const ChangeFigure& figure,
                           const Estimate& change) {
    nlohmann::json json = entry(std::move(whose), figure);
    json["change"] = estimate_json(change);
    json["method"] = figure.method;
    return json;
}

nlohmann::json refused_change_json(nlohmann::json whose,
                                   const ChangeFigure& figure,
                                   const std::string& reason) {
    nlohmann::json json = entry(std::move(whose), figure);
    json["refused"] = reason;
    return json;
}

}  // namespace divemesh::worker
