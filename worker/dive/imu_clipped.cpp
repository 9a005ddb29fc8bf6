#include "worker/dive/imu_clipped.hpp"

#include <cstdint>

#include "worker/base/text.hpp"
#include "worker/dive/clipped_readings.hpp"

namespace divemesh::dive {
namespace {

// No motion is integrated across such a gap. The rows beside clipped ones are almost at the limit,
// so that a line between them would be the clipped reading again.
constexpr std::int64_t kGap_ns = 200'000'000;
constexpr const char* kLeftOut = "the motion in and next to these rows is left out";

struct InertialSensor {
    std::string name;
    std::string unit;
};

void report(const ClippedReadings& clipped,
            std::size_t num_rows,
            const std::string& file,
            const InertialSensor& sensor,
            const std::string& consequence,
            FindingLog& findings) {
    if (clipped.rows.empty()) return;
    findings.warning("imu_clipped",
                     file,
                     "the " + sensor.name + " stops at " + base::significant(clipped.limit) + " " +
                         sensor.unit + " in " + std::to_string(clipped.rows.size()) + " of " +
                         std::to_string(num_rows) +
                         " rows: the motion exceeds the range that it is set to; " + consequence,
                     "Set the " + sensor.name + " to a larger range.");
}

// Extends runs of marked rows at both ends to a gap of kGap_ns.
std::vector<bool> widened(const std::vector<types::ImuSample>& samples,
                          const std::vector<bool>& is_marked) {
    std::vector<bool> is_wide = is_marked;
    for (std::size_t begin = 0; begin < samples.size(); ++begin) {
        if (!is_marked[begin]) continue;
        std::size_t end = begin;
        while (end + 1 < samples.size() && is_marked[end + 1]) ++end;
        const std::int64_t half_ns = (samples[end].timestamp_ns - samples[begin].timestamp_ns) / 2;
        const std::int64_t middle_ns = samples[begin].timestamp_ns + half_ns;
        for (std::size_t i = begin; i-- > 0;) {
            if (middle_ns - samples[i].timestamp_ns > kGap_ns / 2) break;
            is_wide[i] = true;
        }
        for (std::size_t i = end + 1; i < samples.size(); ++i) {
            if (samples[i].timestamp_ns - middle_ns > kGap_ns / 2) break;
            is_wide[i] = true;
        }
        begin = end;
    }
    return is_wide;
}

// Returns the rows that are not marked.
std::vector<types::ImuSample> without(const std::vector<types::ImuSample>& samples,
                                      const std::vector<bool>& is_marked) {
    std::vector<types::ImuSample> kept;
    kept.reserve(samples.size());
    for (std::size_t row = 0; row < samples.size(); ++row)
        if (!is_marked[row]) kept.push_back(samples[row]);
    return kept;
}

// Returns whether so many forces stay clipped without the marked rows that the sensor is not used.
bool stays_spoilt(const std::vector<types::ImuSample>& samples,
                  const std::vector<bool>& is_marked) {
    const std::vector<types::ImuSample> kept = without(samples, is_marked);
    return clipped_forces(kept).spoil(kept.size());
}

}  // namespace

void leave_out_clipped_readings(std::vector<types::ImuSample>& samples,
                                const std::string& file,
                                FindingLog& findings) {
    const std::size_t num_rows = samples.size();
    const ClippedReadings rates = clipped_rates(samples);
    const ClippedReadings forces = clipped_forces(samples);
    std::vector<bool> is_clipped(num_rows, false);
    for (const std::size_t row : rates.rows) is_clipped[row] = true;
    // A shake may clip both sensors, so that the rows without its rates have few clipped forces.
    const bool forces_are_spoilt =
        forces.spoil(num_rows) && stays_spoilt(samples, widened(samples, is_clipped));
    if (!forces_are_spoilt)
        for (const std::size_t row : forces.rows) is_clipped[row] = true;
    report(rates, num_rows, file, {"gyroscope", "rad/s"}, kLeftOut, findings);
    report(forces,
           num_rows,
           file,
           {"accelerometer", "m/s^2"},
           forces_are_spoilt ? "it is not used" : kLeftOut,
           findings);
    samples = without(samples, widened(samples, is_clipped));
}

}  // namespace divemesh::dive
