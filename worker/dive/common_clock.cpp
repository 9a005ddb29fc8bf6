#include "worker/dive/common_clock.hpp"

#include <algorithm>
#include <cstdlib>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kPause_ns = 10'000'000'000;  // no slow card loses as much

std::string seconds(std::int64_t ns, int places = 3) {
    return base::fixed(base::to_s(ns), places) + " s";
}

// The rows of two tables around one step are at most a period apart, each.
bool is_same_clock(const TableClock& a, const TableClock& b) {
    if (a.steps.size() != b.steps.size()) return false;
    const std::int64_t tolerance_ns = 2 * (a.period_ns + b.period_ns);
    return std::equal(a.steps.begin(), a.steps.end(), b.steps.begin(), [&](auto& x, auto& y) {
        return std::abs(x.shift_ns - y.shift_ns) <= tolerance_ns;
    });
}

// Moves rows from the last step backwards, so that a step is found by its own timestamps.
void adopt_shifts(const SteppedTable& table, const TableClock& reference) {
    for (std::size_t k = table.clock.steps.size(); k-- > 0;) {
        const ClockStep& step = table.clock.steps[k];
        const auto difference_ns = [&](std::size_t i) {
            return reference.steps[i].shift_ns - table.clock.steps[i].shift_ns;
        };
        table.move(step.first_after_ns + step.shift_ns,
                   difference_ns(k) - (k > 0 ? difference_ns(k - 1) : 0));
    }
}

void report_steps(const SteppedTable& table, FindingLog& findings) {
    std::int64_t shift_before_ns = 0;
    for (const ClockStep& step : table.clock.steps) {
        findings.warning(
            "clock_set_back",
            table.file,
            "the clock was set back by " + seconds(step.shift_ns - shift_before_ns) +
                " after timestamp " + std::to_string(step.last_before_ns) +
                ". The order of the rows is kept: timestamps from there on are moved by " +
                seconds(step.shift_ns) + ", in the results too, as if nothing was lost between",
            "Do not set the clock during a dive. To find a later moment in other records, subtract "
            "the shift from its timestamp in the results.");
        shift_before_ns = step.shift_ns;
    }
}

bool pauses_between(const std::vector<types::ImuSample>& imu,
                    std::int64_t begin_ns,
                    std::int64_t end_ns) {
    const auto inside = std::count_if(imu.begin(), imu.end(), [&](const types::ImuSample& s) {
        return s.timestamp_ns > begin_ns && s.timestamp_ns < end_ns;
    });
    // An IMU that goes on has far more than ten rows in ten seconds.
    return static_cast<double>(inside) < base::to_s(end_ns - begin_ns);
}

}  // namespace

void join_clocks(const std::vector<SteppedTable>& tables, FindingLog& findings) {
    const auto finest =
        std::min_element(tables.begin(), tables.end(), [](const auto& a, const auto& b) {
            return a.clock.period_ns < b.clock.period_ns;
        });
    if (finest == tables.end()) return;
    report_steps(*finest, findings);
    for (const SteppedTable& table : tables) {
        if (&table == &*finest) continue;
        if (is_same_clock(table.clock, finest->clock))
            adopt_shifts(table, finest->clock);
        else
            report_steps(table, findings);
    }
}

void report_pauses(const std::vector<std::int64_t>& frames_ns,
                   const std::vector<types::ImuSample>& imu,
                   FindingLog& findings) {
    for (std::size_t i = 1; i < frames_ns.size(); ++i) {
        const std::int64_t pause_ns = frames_ns[i] - frames_ns[i - 1];
        if (pause_ns <= kPause_ns) continue;
        const std::string what = pauses_between(imu, frames_ns[i - 1], frames_ns[i])
                                     ? "the clock was set forward, or the recording was paused"
                                     : "the cameras paused while the IMU went on";
        findings.warning(
            "recording_paused",
            "mav0/cam0/data.csv",
            "timestamps jump by " + seconds(pause_ns, 1) + " after frame " + std::to_string(i - 1) +
                " (" + std::to_string(frames_ns[i - 1]) + "): " + what +
                "; the dive is split there",
            "Record each part of a dive without a pause, and set the clock before it.");
    }
}

}  // namespace divemesh::dive
