#include "worker/dive/common_clock.hpp"

#include <algorithm>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kPause_ns = 10'000'000'000;  // no slow card loses as much

std::string seconds(std::int64_t ns, int places = 3) {
    return base::fixed(base::to_s(ns), places) + " s";
}

void report_steps(const std::string& file, const TableClock& clock, FindingLog& findings) {
    std::int64_t shift_before_ns = 0;
    for (const ClockStep& step : clock.steps) {
        findings.warning(
            "clock_set_back",
            file,
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

void CommonClock::add(const std::string& file, const TableClock& clock) {
    if (clock.is_known) return;
    report_steps(file, clock, findings_);
    if (!known_.steps.empty()) return report_contradiction(file);
    if (clock.steps.empty()) {
        earlier_.emplace_back(file, clock);
        return;
    }
    known_ = clock;
    known_file_ = file;
    const std::int64_t step_ns = clock.steps.front().last_before_ns;
    for (const auto& [earlier_file, earlier] : earlier_)
        if (earlier.first_ns < step_ns && earlier.last_ns > step_ns)
            report_contradiction(earlier_file);
}

void CommonClock::report_contradiction(const std::string& file) {
    const ClockStep& step = known_.steps.front();
    findings_.warning(
        "clocks_disagree",
        file,
        "the clock of " + known_file_ + " was set back by " + seconds(step.shift_ns) +
            ", and the timestamps of " + file +
            " do not show it: they may be of other times than those of the other tables from " +
            std::to_string(step.last_before_ns) + " on",
        "Record all sensors by one clock, and do not set it during a dive. If this table has a "
        "clock of its own, compare a motion that both show before and after.");
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
