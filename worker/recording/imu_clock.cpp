#include "worker/recording/imu_clock.hpp"

#include <cmath>
#include <string>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"

namespace divemesh::recording {
namespace {

// The range in which reconstruction searches the time offset of the IMU.
constexpr double kSearched_s = 0.07;

std::string stated_text(const ImuShift& shift) {
    return "the calibration states timeshift_cam_imu = " + base::significant(shift.shift_s * 1e3) +
           " ms; ";
}

}  // namespace

void apply_imu_shift(const RigFiles& rig, DiveWriter& writer, dive::FindingLog& findings) {
    if (!rig.imu_shift || writer.num_imu() == 0) return;
    writer.move_imu(-base::to_ns(rig.imu_shift->shift_s));
    findings.info("calibration_time_offset",
                  rig.imu_shift->file,
                  stated_text(*rig.imu_shift) +
                      "it is taken off the times of the IMU, which are those of the cameras' clock "
                      "now");
}

void report_unapplied_shift(const RigFiles& rig, dive::FindingLog& findings) {
    if (!rig.imu_shift) return;
    const std::string stated = stated_text(*rig.imu_shift) + "it is not applied";
    if (std::abs(rig.imu_shift->shift_s) <= kSearched_s)
        return findings.info("calibration_time_offset",
                             rig.imu_shift->file,
                             stated + ": reconstruction finds it from the dive itself");
    findings.warning("calibration_time_offset",
                     rig.imu_shift->file,
                     stated + " and too large to be found from the dive itself",
                     "Give the calibration to divemesh import with the recording, or take it off "
                     "the times of the IMU (t_imu = t_cam + timeshift_cam_imu).");
}

}  // namespace divemesh::recording
