#include "worker/imu/sensor_watch.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/seconds.hpp"
#include "worker/imu/usable_samples.hpp"

namespace divemesh::imu {
namespace {

constexpr std::size_t kFirstJudgement = 8;  // spans
constexpr std::size_t kJudgementStep = 4;
// The watch notices a fault only after this many wrong spans.
constexpr std::size_t kUnnoticed = 8;
constexpr double kMaxCorrected_s = 0.01;  // of the time offset, while a dive is tracked
// Frames that contradict the IMU for less time may be spoilt themselves.
constexpr std::int64_t kMinContradicted_ns = 400'000'000;
constexpr std::int64_t kMaxBetweenContradictions_ns = 1'000'000'000;
constexpr std::int64_t kContradictionMargin_ns = 200'000'000;
constexpr int kNumLost = 3;  // frames in a row: the scene is lost, not one image spoilt

std::vector<types::ImuSample> shifted(const std::vector<types::ImuSample>& samples,
                                      double offset_s) {
    return offset_s == 0.0 ? samples : aligned(samples, {offset_s});
}

bool overlap(const types::TimeInterval& a, const types::TimeInterval& b) {
    return a.from_ns <= b.to_ns && b.from_ns <= a.to_ns;
}

// Returns the time from the first to the last of `parts` that overlap it; the time itself if none
// does.
types::TimeInterval shortened(const types::TimeInterval& time,
                              const std::vector<types::TimeInterval>& parts) {
    std::optional<types::TimeInterval> result;
    for (const types::TimeInterval& part : parts) {
        if (!overlap(time, part)) continue;
        if (!result) result = part;
        result->from_ns = std::min(result->from_ns, part.from_ns);
        result->to_ns = std::max(result->to_ns, part.to_ns);
    }
    return result.value_or(time);
}

std::vector<types::TimeInterval> joined(std::vector<types::TimeInterval> times) {
    std::sort(
        times.begin(), times.end(), [](const types::TimeInterval& a, const types::TimeInterval& b) {
            return a.from_ns < b.from_ns;
        });
    std::vector<types::TimeInterval> result;
    for (const types::TimeInterval& time : times) {
        if (result.empty() || !overlap(result.back(), time)) result.push_back(time);
        result.back().to_ns = std::max(result.back().to_ns, time.to_ns);
    }
    return result;
}

}  // namespace

SensorWatch::SensorWatch(const types::Recording& recording,
                         const SensorsUsed& used,
                         const SensorPlan& plan)
    : plan_(plan),
      samples_(used.imu ? shifted(without(plan.left_out.imu_times, recording.imu()),
                                  plan.alignment.time_offset_s)
                        : std::vector<types::ImuSample>{}),
      orientations_(used.ahrs ? usable_orientations(recording, plan.left_out)
                              : std::vector<types::OrientationSample>{}),
      gravity_(samples_),
      next_judgement_(kFirstJudgement) {}

void SensorWatch::watch(const VisionMotion& motion, InertialPrior& inertial) {
    num_lost_ = 0;
    const bool judged_already = plan_.left_out.imu && !plan_.imu_unconfirmed;
    if (restart_) return;
    turns_.add(motion.rotation());
    if (samples_.empty() || judged_already) return;
    gravity_.add(motion);
    if (turns_.spans().size() < next_judgement_) return;
    next_judgement_ = turns_.spans().size() + kJudgementStep;
    judge(inertial);
}

void SensorWatch::aligned(const types::ImuAlignment& alignment, std::size_t num_rotations) {
    if (plan_.left_out.imu || restart_) return;
    if (std::abs(alignment.time_offset_s - plan_.alignment.time_offset_s) < kMaxCorrected_s) return;
    restart_ = plan_;
    restart_->alignment = alignment;
    restart_->num_alignment_rotations = num_rotations;
}

void SensorWatch::contradicted_in(const types::TimeInterval& time) {
    if (contradicted_frames_.empty() ||
        time.from_ns - contradicted_frames_.back().to_ns > kMaxBetweenContradictions_ns)
        contradicted_frames_.push_back(time);
    contradicted_frames_.back().to_ns = time.to_ns;
}

void SensorWatch::lost_scene() {
    if (++num_lost_ < kNumLost || samples_.empty()) return;
    if (confirmed_ || plan_.imu_confirmed || plan_.left_out.imu || restart_) return;
    start_again(false);
    restart_->imu_unconfirmed = true;
}

void SensorWatch::start_again(bool with_imu) {
    restart_ = plan_;
    restart_->imu_unconfirmed = false;
    restart_->left_out.imu = !with_imu;
    restart_->imu_confirmed = with_imu;
}

void SensorWatch::judge(InertialPrior& inertial) {
    take(judge_gyroscope(samples_, turns_.spans()), inertial);
    if (!confirmed_ || contradicts_now_ || restart_) return;
    const auto disagreement = gravity_.disagreement_m_s2();
    if (!plan_.left_out.accelerometer &&
        disagreement.value_or(0.0) > kMaxGravityDisagreement_m_s2) {
        start_again(true);
        restart_->left_out.accelerometer = true;
        restart_->gravity_disagreement_m_s2 = *disagreement;
    } else if (plan_.imu_unconfirmed && disagreement) {
        start_again(true);
    }
}

void SensorWatch::take(const GyroscopeJudgement& judgement, InertialPrior& inertial) {
    switch (judgement.fit) {
        case GyroscopeFit::Unknown: return;
        case GyroscopeFit::Fits:
            confirmed_ = true;
            contradicts_now_ = false;
            num_confirmed_ = turns_.spans().size();
            inertial.leave_out_from(std::nullopt);
            return;
        case GyroscopeFit::FitsShifted:
            if (confirmed_) return contradicted(judgement, inertial);
            start_again(true);
            restart_->alignment.time_offset_s += judgement.time_offset_s;
            restart_->num_alignment_rotations = 0;
            restart_->gyroscope = judgement;
            return;
        case GyroscopeFit::Contradicts: return contradicted(judgement, inertial);
    }
}

// Leaves the IMU out: as a whole if it has never fitted, else for the time.
void SensorWatch::contradicted(const GyroscopeJudgement& judgement, InertialPrior& inertial) {
    if (!confirmed_) {
        const bool is_used = !plan_.left_out.imu;
        plan_.imu_unconfirmed = false;
        plan_.left_out.imu = true;
        plan_.gyroscope = judgement;
        if (is_used) start_again(false);
        return;
    }
    const auto& spans = turns_.spans();
    const std::size_t first = num_confirmed_ - std::min(num_confirmed_, kUnnoticed);
    if (contradicted_.empty()) first_contradiction_ = judgement;
    if (!contradicts_now_) contradicted_.push_back({spans[first].from_ns, spans.back().to_ns});
    contradicted_.back().to_ns = spans.back().to_ns;
    contradicts_now_ = true;
    inertial.leave_out_from(spans.back().to_ns);
}

std::optional<SensorPlan> SensorWatch::restart_at_end() const {
    SensorPlan plan = plan_;
    if (plan_.imu_unconfirmed && confirmed_) {  // vision never lasted long enough to test gravity
        plan.imu_unconfirmed = plan.left_out.imu = false;
        plan.imu_confirmed = plan.left_out.accelerometer = true;
        return plan;
    }
    const AhrsJudgement ahrs = judge_ahrs(orientations_, turns_.spans());
    if (ahrs.fault != AhrsFault::None) {
        plan.left_out.ahrs = true;
        plan.ahrs = ahrs;
    } else if (!ahrs.wrong_times.empty()) {
        plan.left_out.ahrs_times.insert(
            plan.left_out.ahrs_times.end(), ahrs.wrong_times.begin(), ahrs.wrong_times.end());
        plan.ahrs = ahrs;
    }
    std::vector<types::TimeInterval> times = wrong_times();
    if (times.empty() && plan.left_out.ahrs == plan_.left_out.ahrs && ahrs.wrong_times.empty())
        return std::nullopt;
    if (!contradicted_.empty()) plan.gyroscope = first_contradiction_;
    const std::int64_t shift_ns = base::to_ns(plan_.alignment.time_offset_s);
    for (types::TimeInterval& time : times) {
        time.from_ns += shift_ns;
        time.to_ns += shift_ns;
    }
    plan.left_out.imu_times.insert(plan.left_out.imu_times.end(), times.begin(), times.end());
    return plan;
}

// Returns the times in which frames contradict the IMU, and in which a confirmed one was wrong by
// its spans, on the cameras' clock. A time that the judgement of the last spans found, too long at
// both ends, is made as short as the times within it that single spans tell; of a long time only
// its ends differ from what is around them.
std::vector<types::TimeInterval> SensorWatch::wrong_times() const {
    std::vector<types::TimeInterval> times;
    for (const types::TimeInterval& time : contradicted_frames_)
        if (time.to_ns - time.from_ns >= kMinContradicted_ns)
            times.push_back(
                {time.from_ns - kContradictionMargin_ns, time.to_ns + kContradictionMargin_ns});
    if (!confirmed_) return joined(std::move(times));
    const auto add = [&](const std::vector<types::TimeInterval>& found) {
        times.insert(times.end(), found.begin(), found.end());
    };
    add(imu::wrong_times(samples_, turns_.spans()));
    if (!plan_.left_out.accelerometer) add(gravity_.wrong_times());
    std::vector<types::TimeInterval> judged;
    for (const types::TimeInterval& time : contradicted_) judged.push_back(shortened(time, times));
    add(judged);
    return joined(std::move(times));
}

}  // namespace divemesh::imu
