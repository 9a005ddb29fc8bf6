#include "worker/pipeline/sensor_attempts.hpp"

#include "worker/dive/clipped_readings.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kMaxAttempts = 5;  // without those that try an unconfirmed IMU
// Shares of the frames: lost by vision alone, so that the IMU is tried, and gained by it.
constexpr double kMinLost = 0.1;
constexpr double kMinGained = 0.05;

}  // namespace

// The dive's findings tell of clipped readings.
SensorAttempts::SensorAttempts(const types::Recording& recording) {
    const auto& samples = recording.imu();
    plan_.accelerometer_clipped = dive::clipped_forces(samples).spoil(samples.size());
    plan_.left_out.accelerometer = plan_.accelerometer_clipped;
}

bool SensorAttempts::again(const imu::SensorWatch& watch, const types::Track& track) {
    auto other = watch.restart();
    const bool is_whole = !other;
    if (!other) other = watch.restart_at_end();
    const std::int64_t num_measured = types::num_by_vision(track);
    const auto num_frames = std::ssize(track.motions);
    if (alone_) return judge_trial(is_whole, num_measured, num_frames);
    if (!other) {
        plan_ = watch.plan();
        return try_unconfirmed(num_measured, num_frames);
    }
    const types::SensorsLeftOut& tracked = watch.plan().left_out;
    const bool drops_ahrs = other->left_out.ahrs && !tracked.ahrs;  // once
    const bool adds_times = is_whole && other->left_out.imu == tracked.imu;
    plan_ = *other;
    ++num_made_;
    if (num_made_ + 1 < kMaxAttempts || drops_ahrs) return true;
    if (adds_times) return num_made_ + 1 == kMaxAttempts;  // then the path is taken as it is
    // Without the IMU nothing asks for another attempt.
    plan_.left_out.imu = true;
    plan_.imu_unconfirmed = false;
    plan_.imu_unsettled = true;
    plan_.gyroscope.fault = imu::GyroscopeFault::None;
    return true;
}

bool SensorAttempts::try_unconfirmed(std::int64_t num_measured, std::int64_t num_frames) {
    const auto num_lost = static_cast<double>(num_frames - num_measured);
    if (tried_ || !plan_.imu_unconfirmed || num_lost < kMinLost * static_cast<double>(num_frames))
        return false;
    tried_ = true;
    alone_ = plan_;
    num_measured_alone_ = num_measured;
    plan_.left_out.imu = false;
    plan_.imu_unconfirmed = false;
    plan_.imu_confirmed = true;
    return true;
}

bool SensorAttempts::judge_trial(bool is_whole,
                                 std::int64_t num_measured,
                                 std::int64_t num_frames) {
    const auto num_gained = static_cast<double>(num_measured - num_measured_alone_);
    const bool helped = is_whole && num_gained >= kMinGained * static_cast<double>(num_frames);
    if (!helped) plan_ = *alone_;
    alone_.reset();
    return !helped;
}

}  // namespace divemesh::pipeline
