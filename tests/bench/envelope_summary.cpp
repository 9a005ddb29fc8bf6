#include "tests/bench/envelope_summary.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/bench/envelope_judge.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::bench {
namespace {

using nlohmann::json;

using Value = std::function<json(const json& run)>;

// Median and worst, the largest, of what runs state; null where none does.
json spread(const json& runs, const Value& value) {
    std::vector<double> values;
    for (const json& run : runs)
        if (const json stated = value(run); stated.is_number())
            values.push_back(stated.get<double>());
    if (values.empty()) return {{"median", nullptr}, {"worst", nullptr}, {"num", 0}};
    return {{"median", stats::median(values)},
            {"worst", *std::max_element(values.begin(), values.end())},
            {"num", values.size()}};
}

json percent_of_path(const json& run, const json& length_m) {
    if (!length_m.is_number() || run["path_m"] == 0.0) return nullptr;
    return 100.0 * length_m.get<double>() / run["path_m"].get<double>();
}

void count(json& counts, const json& word) {
    if (word.is_string()) counts[word] = counts.value(word.get<std::string>(), 0) + 1;
}

json counted(const json& runs, const char* field) {
    json counts = json::object();
    for (const json& run : runs) {
        const json words = run.value(field, json());
        if (words.is_array())
            for (const json& word : words) count(counts, word);
        else
            count(counts, words);
    }
    return counts;
}

json runs_of_step(const json& runs, const std::string& axis, const std::string& step) {
    json found = json::array();
    for (const json& run : runs)
        if (run["axis"] == axis && run["step"] == step) found.push_back(run);
    return found;
}

json summarise_step(const json& runs) {
    json row = {{"num_runs", runs.size()},
                {"num_working", std::count_if(runs.begin(), runs.end(), works)},
                {"num_failed", std::count_if(runs.begin(), runs.end(), [](const json& run) {
                     return run["exit_code"] != 0;
                 })}};
    row["lost_share"] =
        spread(runs, [](const json& run) { return 1.0 - run["tracked_share"].get<double>(); });
    row["ate_percent"] =
        spread(runs, [](const json& run) { return percent_of_path(run, run["ate_m"]); });
    row["bound_percent"] =
        spread(runs, [](const json& run) { return percent_of_path(run, run["bound_m"]); });
    row["scale_error_percent"] = spread(runs, [](const json& run) -> json {
        if (!run["scale"].is_number()) return nullptr;
        return 100.0 * std::abs(run["scale"].get<double>() - 1.0);
    });
    row["sift_unlinked_share"] = spread(runs, [](const json& run) -> json {
        if (!run.contains("sift")) return nullptr;
        return 1.0 - run["sift"]["linked_share"].get<double>();
    });
    row["sift_ate_percent"] = spread(runs, [](const json& run) -> json {
        if (!run.contains("sift")) return nullptr;
        return percent_of_path(run, run["sift"]["ate_m"]);
    });
    row["moving_share"] =
        spread(runs, [](const json& run) { return run.value("moving_share", json()); });
    row["verdicts"] = counted(runs, "verdict");
    row["findings"] = counted(runs, "findings");
    row["num_silent"] = std::count_if(runs.begin(), runs.end(), is_silent);
    row["num_hollow"] = std::count_if(runs.begin(), runs.end(), is_hollow_success);
    return row;
}

}  // namespace

json summarise(const EnvelopeAxis& axis, const json& runs) {
    json rows = json::array();
    for (const EnvelopeStep& step : axis.steps) {
        const json of_step = runs_of_step(runs, axis.name, step.label);
        if (of_step.empty()) continue;
        json row = summarise_step(of_step);
        row["axis"] = axis.name;
        row["step"] = step.label;
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace divemesh::bench
