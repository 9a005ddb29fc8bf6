#include "worker/dive/imu_clipped.hpp"

#include "worker/base/text.hpp"
#include "worker/dive/clipped_readings.hpp"

namespace divemesh::dive {
namespace {

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

}  // namespace

void leave_out_clipped_readings(std::vector<types::ImuSample>& samples,
                                const std::string& file,
                                FindingLog& findings) {
    const std::size_t num_rows = samples.size();
    const ClippedReadings rates = clipped_rates(samples);
    const ClippedReadings forces = clipped_forces(samples);
    const bool forces_are_spoilt = forces.spoil(num_rows);
    report(rates, num_rows, file, {"gyroscope", "rad/s"}, "these rows are left out", findings);
    report(forces,
           num_rows,
           file,
           {"accelerometer", "m/s^2"},
           forces_are_spoilt ? "it is not used" : "these rows are left out",
           findings);
    std::vector<bool> is_clipped(num_rows, false);
    for (const std::size_t row : rates.rows) is_clipped[row] = true;
    if (!forces_are_spoilt)
        for (const std::size_t row : forces.rows) is_clipped[row] = true;
    std::vector<types::ImuSample> kept;
    kept.reserve(num_rows);
    for (std::size_t row = 0; row < num_rows; ++row)
        if (!is_clipped[row]) kept.push_back(samples[row]);
    samples = std::move(kept);
}

}  // namespace divemesh::dive
