#include "tests/bench/envelope_judge.hpp"

#include <algorithm>

namespace divemesh::bench {
namespace {

using nlohmann::json;

constexpr double kTracked = 0.9;
constexpr double kMaxError = 0.005;  // of the path
constexpr double kMaxErrorToBound = 3.0;
constexpr double kHollow = 0.1;  // of the frames

bool says_something(const json& run) {
    const json verdict = run.value("verdict", json());
    return run["exit_code"] != 0 || !run["findings"].empty() ||
           (verdict.is_string() && verdict != "good");
}

}  // namespace

bool works(const json& run) {
    return run["exit_code"] == 0 && run["tracked_share"] >= kTracked && run["ate_m"].is_number() &&
           run["ate_m"].get<double>() <= kMaxError * run["path_m"].get<double>();
}

bool breaks_bound(const json& run) {
    return run["ate_m"].is_number() && run["bound_m"].is_number() &&
           run["ate_m"].get<double>() > kMaxErrorToBound * run["bound_m"].get<double>();
}

bool is_silent(const json& run) {
    if (says_something(run)) return false;
    if (!run["ate_m"].is_number() || !run["bound_m"].is_number()) return !works(run);
    return breaks_bound(run);
}

bool is_hollow_success(const json& run) {
    return run["exit_code"] == 0 && run["tracked_share"] < kHollow;
}

json edge_of(const std::vector<std::string>& steps, const json& runs) {
    const auto fails = [&](const std::string& step) {
        return std::any_of(runs.begin(), runs.end(), [&](const json& run) {
            return run["step"] == step && !works(run);
        });
    };
    const auto bad = std::find_if(steps.begin(), steps.end(), fails);
    return {{"last_good", bad == steps.begin() ? json() : json(*std::prev(bad))},
            {"first_bad", bad == steps.end() ? json() : json(*bad)}};
}

}  // namespace divemesh::bench
