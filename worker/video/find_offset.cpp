#include "worker/video/find_offset.hpp"

#include <cmath>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/video/motion_offset.hpp"

namespace divemesh::video {
namespace {

constexpr double kMaxSound_s = 1200.0;  // drift is known to a part in a million by then
constexpr double kDay_s = 86400.0;
constexpr double kContradiction_s = 0.05;

// An offset, and what it is known by.
struct Witness {
    ClockOffset clock;
    const char* by = "";
};

std::string seconds_text(double seconds) { return base::fixed(seconds, 4) + " s"; }

std::optional<ClockOffset> offset_by_creation(const VideoTraits& left, const VideoTraits& right) {
    if (!left.has_fine_creation || !right.has_fine_creation) return std::nullopt;
    constexpr double kSigma_s = 0.01;  // a file is created a little before its first frame
    return ClockOffset{base::to_s(*right.creation_ns - *left.creation_ns), 0.0, kSigma_s};
}

std::optional<ClockOffset> offset_by_timecode(const IndexedVideo& left, const IndexedVideo& right) {
    if (!left.index.traits.timecode_s || !right.index.traits.timecode_s) return std::nullopt;
    const double offset_s = *right.index.traits.timecode_s - *left.index.traits.timecode_s;
    const double period_s = std::max(left.index.period_s(), right.index.period_s());
    // Both count whole frames.
    return ClockOffset{std::remainder(offset_s, kDay_s), 0.0, period_s / std::sqrt(6.0)};
}

// Returns whether the videos overlap by an offset.
bool overlap(const IndexedVideo& left, const IndexedVideo& right, const ClockOffset& clock) {
    return clock.left_ns(right.index.stamps_ns.front()) <= left.index.stamps_ns.back() &&
           clock.left_ns(right.index.stamps_ns.back()) >= left.index.stamps_ns.front();
}

void report(const Witness& witness, const IndexedVideo& right, dive::FindingLog& findings) {
    const ClockOffset& clock = witness.clock;
    std::string text = "0 of this video is " + seconds_text(clock.offset_s);
    text += " on the clock of the left one, by ";
    text += witness.by;
    if (clock.sigma_s > 0.0) text += " (+- " + base::fixed(2e3 * clock.sigma_s, 2) + " ms)";
    if (clock.drift != 0.0)
        text += ", and its clock gains " + base::fixed(1e6 * clock.drift, 1) + " parts per million";
    findings.info("video_offset", right.name(), text);
}

void report_unknown(const IndexedVideo& right, dive::FindingLog& findings) {
    findings.warning("video_offset_unknown",
                     right.name(),
                     "neither sound, nor motion, nor the files' own times tell when this video "
                     "began: both are taken to begin together",
                     "State the difference by --offset: the time of a flash or a clap in the left "
                     "video minus its time in the right one.");
}

void report_contradiction(const ClockOffset& heard,
                          const ClockOffset& stated,
                          const IndexedVideo& right,
                          dive::FindingLog& findings) {
    if (std::abs(heard.offset_s - stated.offset_s) < kContradiction_s) return;
    findings.warning("video_offset_contradicted",
                     right.name(),
                     "the times at which the files were created say " +
                         seconds_text(stated.offset_s) + ", the sound says " +
                         seconds_text(heard.offset_s) + ", which is used",
                     "Set both cameras by one clock, or state the difference by --offset.");
}

}  // namespace

ClockOffset find_offset(const IndexedVideo& left,
                        const IndexedVideo& right,
                        std::optional<double> stated_s,
                        dive::FindingLog& findings,
                        const base::ProgressCallback& progress) {
    const auto taken = [&](const std::optional<ClockOffset>& clock, const char* by) {
        if (!clock || !overlap(left, right, *clock)) return false;
        report({*clock, by}, right, findings);
        return true;
    };
    if (stated_s) return {*stated_s, 0.0, 0.0};
    const auto heard = offset_by_sound(read_sound(left.parts, kMaxSound_s, progress),
                                       read_sound(right.parts, kMaxSound_s, progress));
    const auto created = offset_by_creation(left.index.traits, right.index.traits);
    if (heard && created) report_contradiction(*heard, *created, right, findings);
    if (taken(heard, "what both cameras heard")) return *heard;
    if (taken(created, "when the files were created")) return *created;
    const auto moved = offset_by_motion(left, right, progress);
    if (taken(moved, "how the images move")) return *moved;
    const auto timed = offset_by_timecode(left, right);
    if (taken(timed, "the timecodes, to a frame")) return *timed;
    report_unknown(right, findings);
    return {};
}

}  // namespace divemesh::video
