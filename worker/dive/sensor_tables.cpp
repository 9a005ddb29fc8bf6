#include "worker/dive/sensor_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "worker/base/text.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMinPeriod_s = 2e-5;  // 50 kHz; milli- and microseconds give far shorter periods
constexpr double kMaxReading = 1e9;  // above every sensor's range in any unit; squares stay finite

// Reads rows of a timestamp and N numbers. `use` returns a sample, or nullopt for numbers that are
// none.
template <std::size_t N, typename Sample, typename Use>
std::vector<Sample> read_samples(std::string_view text,
                                 StampCheck& check,
                                 SetBack set_back,
                                 const Use& use) {
    std::vector<Sample> samples;
    for_each_csv_row(text, [&](std::int64_t line, std::span<const std::string_view> fields) {
        const auto timestamp = check.accept(line, fields[0]);
        if (!timestamp) return;
        std::array<double, N> values{};
        for (std::size_t i = 0; i < N; ++i) {
            const auto value =
                i + 1 < fields.size() ? parse_double(fields[i + 1]) : std::optional<double>();
            if (!value) return check.count_malformed(line);
            values[i] = *value;
        }
        if (!std::all_of(values.begin(), values.end(), [](double value) {
                return std::abs(value) <= kMaxReading;  // false for NaN
            }))
            return check.count_not_finite(line);
        const std::optional<Sample> sample = use(*timestamp, values);
        if (!sample) return check.count_malformed(line);
        samples.push_back(*sample);
        check.keep(line);
    });
    check.finish(samples, kMinPeriod_s, set_back);
    return samples;
}

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
    constexpr Unit units[] = {{1.0, "g"}, {980.7, "cm/s^2"}, {9806.7, "mm/s^2 or mg"}};
    const std::string seen = "the median acceleration is " + base::significant(median_m_s2);
    for (const Unit& unit : units)
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
    if (std::abs(median_m_s2 - 9.81) > 0.6)
        findings.warning("gravity_check",
                         file,
                         seen + " m/s^2 instead of 9.81",
                         "Calibrate the bias and scale of the accelerometer.");
}

void check_imu_units(const std::vector<types::ImuSample>& samples,
                     const std::string& file,
                     FindingLog& findings) {
    if (samples.empty()) return;
    check_acceleration(
        median_of(samples, [](const types::ImuSample& s) { return s.acceleration_imu.norm(); }),
        file,
        findings);
    const double rate =
        median_of(samples, [](const types::ImuSample& s) { return s.angular_velocity_imu.norm(); });
    if (rate > 2.0 * std::numbers::pi)
        findings.error("imu_units",
                       file,
                       "the median rotation rate is " + base::significant(rate) +
                           " rad/s, more than one turn per second; this looks like degrees/s",
                       "Write rates in rad/s.");
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
                                        FindingLog& findings) {
    StampCheck check("imu", file, findings);
    auto samples = read_samples<6, types::ImuSample>(
        text, check, SetBack::Keep, [](std::int64_t timestamp_ns, const auto& v) {
            return types::ImuSample{timestamp_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
        });
    check_imu_units(samples, file, findings);
    return samples;
}

std::vector<types::OrientationSample> parse_ahrs(std::string_view text,
                                                 const std::string& file,
                                                 FindingLog& findings) {
    StampCheck check("ahrs", file, findings);
    return read_samples<4, types::OrientationSample>(
        text, check, SetBack::Keep, [](std::int64_t timestamp_ns, const auto& v) {
            const auto q = unit_quaternion(v[0], v[1], v[2], v[3]);
            return q ? std::optional(types::OrientationSample{timestamp_ns, *q}) : std::nullopt;
        });
}

std::vector<types::PressureSample> parse_pressure(std::string_view text,
                                                  const std::string& file,
                                                  FindingLog& findings) {
    StampCheck check("pressure", file, findings);
    auto samples = read_samples<1, types::PressureSample>(
        text, check, SetBack::Keep, [](std::int64_t timestamp_ns, const auto& v) {
            return types::PressureSample{timestamp_ns, v[0]};
        });
    const auto absurd =
        std::count_if(samples.begin(), samples.end(), [](const types::PressureSample& s) {
            return s.depth_m < -20.0 || s.depth_m > 11000.0;
        });
    if (absurd * 20 > std::ssize(samples))
        findings.error(
            "pressure_units",
            file,
            std::to_string(absurd) + " of " + std::to_string(samples.size()) +
                " depths are above the surface or deeper than any sea, so they are not depths in m",
            "Write the depth in m, positive down, not the pressure in Pa or mbar.");
    return samples;
}

types::Trajectory parse_ground_truth(std::string_view text,
                                     const std::string& file,
                                     FindingLog& findings) {
    StampCheck check("ground_truth", file, findings);
    return read_samples<7, types::StampedPose>(
        text,
        check,
        SetBack::Refuse,
        [](std::int64_t timestamp_ns, const auto& v) -> std::optional<types::StampedPose> {
            const auto q = unit_quaternion(v[3], v[4], v[5], v[6]);
            if (!q || Eigen::Vector3d(v[0], v[1], v[2]).norm() > 1e7) return std::nullopt;
            types::StampedPose pose;
            pose.timestamp_ns = timestamp_ns;
            pose.T_world_imu = Eigen::Translation3d(v[0], v[1], v[2]) * *q;
            return pose;
        });
}

}  // namespace divemesh::dive
