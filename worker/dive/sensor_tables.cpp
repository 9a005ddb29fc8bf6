#include "worker/dive/sensor_tables.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/ahrs_jumps.hpp"
#include "worker/dive/imu_clipped.hpp"
#include "worker/dive/imu_frozen.hpp"
#include "worker/dive/imu_zeros.hpp"
#include "worker/dive/read_samples.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::dive {
namespace {

constexpr double kAboveSurface_m = -1.0;  // waves and a zero that drifts stay below this
constexpr double kMaxDepth_m = 11000.0;
constexpr double kMinPressure_mbar = 900.0;  // of the air 1000 m above the sea
constexpr double kMaxChange_m_s = 2.0;       // of a vehicle's depth
constexpr double kMaxGravityError = 0.6;     // m/s^2, of a median of accelerations
constexpr double kMaxImuPeriod_s = 0.1;
constexpr double kMaxDiverRate_rad_s = 3.0;  // a median above it is no diver's

template <typename Get>
double median_of(const std::vector<types::ImuSample>& samples, const Get& get) {
    std::vector<double> values;
    values.reserve(samples.size());
    for (const types::ImuSample& sample : samples) values.push_back(get(sample));
    return stats::upper_median(std::move(values));
}

// Checks the unit by gravity: the mean specific force of a diver is that of gravity.
void check_acceleration(double median_m_s2, const std::string& file, FindingLog& findings) {
    struct Unit {
        double gravity;
        const char* name;
    };
    constexpr Unit kUnits[] = {{1.0, "g"}, {980.7, "cm/s^2"}, {9806.7, "mm/s^2 or mg"}};
    const std::string seen = "the median acceleration is " + base::significant(median_m_s2);
    for (const Unit& unit : kUnits)
        if (std::abs(median_m_s2 / unit.gravity - 1.0) < 0.2)
            return findings.error(
                "imu_units",
                file,
                seen + " instead of 9.81 m/s^2; this looks like " + unit.name,
                "Write accelerations in m/s^2, gravity included (about 9.81 at rest).");
    if (median_m_s2 < 4.0 || median_m_s2 > 25.0)
        return findings.error(
            "imu_units",
            file,
            seen + " instead of about 9.81 m/s^2: gravity is missing or the unit is wrong",
            "Write the specific force in m/s^2, gravity included.");
    if (std::abs(median_m_s2 - 9.81) > kMaxGravityError)
        findings.warning("gravity_check",
                         file,
                         seen + " m/s^2 instead of 9.81",
                         "Calibrate the bias and scale of the accelerometer.");
}

void check_imu_units(const std::vector<types::ImuSample>& samples,
                     const std::string& file,
                     FindingLog& findings) {
    if (samples.empty()) return;
    const double acceleration =
        median_of(samples, [](const types::ImuSample& s) { return s.acceleration_imu.norm(); });
    const double rate =
        median_of(samples, [](const types::ImuSample& s) { return s.angular_velocity_imu.norm(); });
    if (std::abs(rate - 9.81) < kMaxGravityError && acceleration < kMaxDiverRate_rad_s)
        return findings.error("imu_units",
                              file,
                              "the first three values of a row are those of an accelerometer "
                              "(median " +
                                  base::significant(rate) +
                                  "), the last three those of a gyroscope: their columns are "
                                  "exchanged",
                              "Write in each row the timestamp, the rotation rates (rad/s), then "
                              "the accelerations (m/s^2).");
    check_acceleration(acceleration, file, findings);
    if (rate > 2.0 * std::numbers::pi)
        findings.error("imu_units",
                       file,
                       "the median rotation rate is " + base::significant(rate) +
                           " rad/s, more than one turn per second; this looks like degrees/s",
                       "Write rates in rad/s.");
}

// Over longer intervals the rotation is not known, and no preset uses the IMU.
void check_imu_rate(const std::vector<types::ImuSample>& samples,
                    const std::string& file,
                    FindingLog& findings) {
    const double period_s = base::to_s(median_period_ns(timestamps_of(samples)));
    if (period_s <= kMaxImuPeriod_s) return;
    findings.warning("imu_slow",
                     file,
                     "the IMU has a reading every " + base::fixed(period_s, 2) +
                         " s, too few to tell how the rig moved, so the path does not use it",
                     "Record the IMU at 100 readings a second or more; 10 are the least.");
}

// Returns the change of depth per second that nine in ten changes over a second do not exceed, m/s.
double fast_change_m_s(const std::vector<types::PressureSample>& samples) {
    constexpr std::int64_t kOver_ns = 1'000'000'000;
    std::vector<double> changes_m_s;
    std::size_t from = 0;
    for (const types::PressureSample& sample : samples) {
        if (sample.timestamp_ns - samples[from].timestamp_ns < kOver_ns) continue;
        changes_m_s.push_back(std::abs(sample.depth_m - samples[from].depth_m) /
                              base::to_s(sample.timestamp_ns - samples[from].timestamp_ns));
        while (sample.timestamp_ns - samples[from].timestamp_ns >= kOver_ns) ++from;
    }
    return stats::upper_quantile(std::move(changes_m_s), 0.9);
}

// Reports numbers that are those of a pressure in mbar, about 1013 at the surface. Depths of a deep
// vehicle may be as large, but do not change as fast. Returns true if it reported any.
bool check_millibars(const std::vector<types::PressureSample>& samples,
                     const std::string& file,
                     FindingLog& findings) {
    std::vector<double> values;
    values.reserve(samples.size());
    for (const types::PressureSample& sample : samples) values.push_back(sample.depth_m);
    const double low = stats::lower_quantile(values, 0.05);
    const double median = stats::upper_median(std::move(values));
    if (low < kMinPressure_mbar || median > kMaxDepth_m) return false;
    const std::string seen = "the median depth is " + base::fixed(median, 0) + " m";
    const std::string remedy =
        "Write the depth in m: (mbar - 1013.25) / 100.5 in sea water, / 98.1 in fresh water.";
    const double change_m_s = fast_change_m_s(samples);
    if (change_m_s > kMaxChange_m_s)
        findings.error("pressure_units",
                       file,
                       seen + " and changes by up to " + base::fixed(change_m_s, 0) +
                           " m a second; this looks like a pressure in mbar (hPa)",
                       remedy);
    else
        findings.info(
            "pressure_units",
            file,
            seen + "; if the dive was not as deep, this is a pressure in mbar (hPa). " + remedy);
    return true;
}

// Checks the unit and the sign of depths.
void check_depths(const std::vector<types::PressureSample>& samples,
                  const std::string& file,
                  FindingLog& findings) {
    const auto num_where = [&](const auto& is_wrong) {
        return std::count_if(samples.begin(), samples.end(), [&](const types::PressureSample& s) {
            return is_wrong(s.depth_m);
        });
    };
    const auto num_absurd = num_where([](double d) { return d < -20.0 || d > kMaxDepth_m; });
    const auto num_above = num_where([](double d) { return d < kAboveSurface_m && d > -11000.0; });
    const std::string of = " of " + std::to_string(samples.size()) + " depths are ";
    if (check_millibars(samples, file, findings)) return;
    if (num_above > 0 && num_above * 20 >= std::ssize(samples) * 19)
        return findings.warning(
            "pressure_sign",
            file,
            std::to_string(num_above) + of +
                "negative, which is above the surface: depths seem to be written downwards as "
                "negative numbers",
            "Write the depth as positive below the surface, or set the sensor's zero at the "
            "surface.");
    if (num_absurd * 20 > std::ssize(samples))
        findings.error("pressure_units",
                       file,
                       std::to_string(num_absurd) + of +
                           "above the surface or deeper than any sea, so they are not depths in m",
                       "Write the depth in m, positive down, not the pressure in Pa or mbar.");
}

std::optional<Eigen::Quaterniond> unit_quaternion(double w, double x, double y, double z) {
    const Eigen::Quaterniond q(w, x, y, z);
    const double norm = q.norm();
    if (std::abs(norm - 1.0) > 0.05) return std::nullopt;
    return q.normalized();
}

}  // namespace

std::vector<types::ImuSample> parse_imu(std::string_view text,
                                        const std::string& file,
                                        FindingLog& findings,
                                        CommonClock* clock) {
    StampCheck check("imu", file, findings);
    // Where gyroscope and accelerometer are read at separate times, the fields of the other are
    // empty, or zero: fill_zero_readings() handles both.
    auto samples = read_samples<6, types::ImuSample>(
        text,
        check,
        clock,
        [](std::int64_t timestamp_ns, const auto& v) {
            return std::optional<types::ImuSample>(
                {timestamp_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
        },
        [](const types::ImuSample& a, const types::ImuSample& b) {
            return a.angular_velocity_imu == b.angular_velocity_imu &&
                   a.acceleration_imu == b.acceleration_imu;
        },
        EmptyFields::Zero);
    fill_zero_readings(samples, file, findings);
    leave_out_frozen_readings(samples, file, findings);
    leave_out_clipped_readings(samples, file, findings);
    check_imu_units(samples, file, findings);
    check_imu_rate(samples, file, findings);
    return samples;
}

std::vector<types::OrientationSample> parse_ahrs(std::string_view text,
                                                 const std::string& file,
                                                 FindingLog& findings,
                                                 CommonClock* clock) {
    StampCheck check("ahrs", file, findings);
    auto samples = read_samples<4, types::OrientationSample>(
        text,
        check,
        clock,
        [](std::int64_t timestamp_ns, const auto& v) -> std::optional<types::OrientationSample> {
            const auto q = unit_quaternion(v[0], v[1], v[2], v[3]);
            if (!q) return std::nullopt;
            return types::OrientationSample{timestamp_ns, *q};
        },
        [](const types::OrientationSample& a, const types::OrientationSample& b) {
            return a.q_world_imu.coeffs() == b.q_world_imu.coeffs();
        });
    take_off_ahrs_jumps(samples, file, findings);
    return samples;
}

std::vector<types::PressureSample> parse_pressure(std::string_view text,
                                                  const std::string& file,
                                                  FindingLog& findings,
                                                  CommonClock* clock) {
    StampCheck check("pressure", file, findings);
    auto samples = read_samples<1, types::PressureSample>(
        text,
        check,
        clock,
        [](std::int64_t timestamp_ns, const auto& v) {
            return std::optional<types::PressureSample>({timestamp_ns, v[0]});
        },
        [](const types::PressureSample& a, const types::PressureSample& b) {
            return a.depth_m == b.depth_m;
        });
    check_depths(samples, file, findings);
    return samples;
}

types::Trajectory parse_ground_truth(std::string_view text,
                                     const std::string& file,
                                     FindingLog& findings,
                                     CommonClock* clock) {
    StampCheck check("ground_truth", file, findings);
    return read_samples<7, types::StampedPose>(
        text,
        check,
        clock,
        [](std::int64_t timestamp_ns, const auto& v) -> std::optional<types::StampedPose> {
            const auto q = unit_quaternion(v[3], v[4], v[5], v[6]);
            if (!q || Eigen::Vector3d(v[0], v[1], v[2]).norm() > 1e7) return std::nullopt;
            types::StampedPose pose;
            pose.timestamp_ns = timestamp_ns;
            pose.T_world_imu = Eigen::Translation3d(v[0], v[1], v[2]) * *q;
            return pose;
        },
        [](const types::StampedPose& a, const types::StampedPose& b) {
            return a.T_world_imu.matrix() == b.T_world_imu.matrix();
        });
}

}  // namespace divemesh::dive
