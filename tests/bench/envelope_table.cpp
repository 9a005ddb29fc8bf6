#include "tests/bench/envelope_table.hpp"

#include <spdlog/fmt/fmt.h>

#include "tests/bench/envelope_judge.hpp"

namespace divemesh::bench {
namespace {

using nlohmann::json;

std::string number(const json& value, int digits) {
    return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), digits) : "-";
}

// "median (worst)"; one value where both are one run's.
std::string both(const json& spread, int digits, double times = 1.0) {
    if (!spread["median"].is_number()) return "-";
    const std::string median = number(times * spread["median"].get<double>(), digits);
    const std::string worst = number(times * spread["worst"].get<double>(), digits);
    return spread["num"] == 1 || median == worst ? median : median + " (" + worst + ")";
}

std::string list(const json& counts) {
    std::string text;
    for (const auto& [word, count] : counts.items())
        text += (text.empty() ? "" : ", ") + word +
                (count > 1 ? " x" + std::to_string(count.get<int>()) : "");
    return text;
}

std::string said(const json& row) {
    std::string text = list(row["verdicts"]);
    const std::string findings = list(row["findings"]);
    if (!text.empty() && !findings.empty()) text += ": ";
    text += findings;
    if (row["num_failed"] > 0)
        text += (text.empty() ? "" : "; ") +
                fmt::format("exit code not 0 x{}", row["num_failed"].get<int>());
    return text.empty() ? "-" : text;
}

std::string label(const json& row) {
    const json& moving = row["moving_share"]["median"];
    const auto step = row["step"].get<std::string>();
    return moving.is_number()
               ? fmt::format("{} ({:.0f} % of the image)", step, 100.0 * moving.get<double>())
               : step;
}

std::string step_row(const json& row) {
    return fmt::format("| {} | {} | {}/{} | {} | {} | {} | {} | {} | {} | {} |\n",
                       row["axis"].get<std::string>(),
                       label(row),
                       row["num_working"].get<int>(),
                       row["num_runs"].get<int>(),
                       both(row["lost_share"], 0, 100.0),
                       both(row["ate_percent"], 2),
                       both(row["bound_percent"], 2),
                       both(row["scale_error_percent"], 2),
                       both(row["sift_unlinked_share"], 0, 100.0),
                       both(row["sift_ate_percent"], 2),
                       said(row));
}

std::string word(const json& value) { return value.is_string() ? value.get<std::string>() : "-"; }

std::string edges_table(const json& edges) {
    std::string text = "| axis | works to | breaks at |\n|---|---|---|\n";
    for (const json& edge : edges)
        text += fmt::format("| {} | {} | {} |\n",
                            edge["axis"].get<std::string>(),
                            word(edge["last_good"]),
                            word(edge["first_bad"]));
    return text;
}

std::string silent_list(const json& report) {
    const auto line = [](const json& run) {
        return fmt::format("- {}, {}: {} {}, error {} m, bound {} m, {} % tracked\n",
                           run["axis"].get<std::string>(),
                           run["step"].get<std::string>(),
                           run["scene"].get<std::string>(),
                           run["seed"].get<int>(),
                           number(run["ate_m"], 3),
                           number(run["bound_m"], 3),
                           number(100.0 * run["tracked_share"].get<double>(), 0));
    };
    std::string text = fmt::format(
        "Runs: {}. Error above three times the bound: {}; failed with nothing said: {}. "
        "Exit code 0 with less than a tenth tracked: {}.\n\n",
        report["num_runs"].get<int>(),
        report["beyond"].size(),
        report["silent"].size(),
        report["hollow"].size());
    for (const json& run : report["beyond"]) text += line(run);
    for (const json& run : report["silent"])
        if (!breaks_bound(run)) text += line(run);
    for (const json& run : report["hollow"]) text += line(run);
    return text;
}

}  // namespace

std::string envelope_table(const json& report) {
    std::string text = edges_table(report["edges"]) + "\n" + silent_list(report) + "\n" +
                       "| axis | step | works | lost, % | error, % of path | stated bound, % | "
                       "scale error, % | SIFT: links missing, % | SIFT: error, % of path | said "
                       "|\n|---|---|---|---|---|---|---|---|---|---|\n";
    for (const json& row : report["steps"]) text += step_row(row);
    return text;
}

}  // namespace divemesh::bench
