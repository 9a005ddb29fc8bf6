#include "worker/pipeline/sensor_findings.hpp"

#include <cmath>
#include <string>

#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/imu/measured_noise.hpp"

namespace divemesh::pipeline {
namespace {

constexpr const char* kImuTable = "mav0/imu0/data.csv";
constexpr const char* kAhrsTable = "mav0/ahrs0/data.csv";
constexpr const char* kPressureTable = "mav0/pressure0/data.csv";
constexpr double kMinToldOffset_s = 1e-3;  // of two clocks

std::string percent(double share) { return base::fixed(100.0 * share, 0) + " %"; }

std::string axis_or_axes(const std::string& axes) {
    return (axes.size() > 1 ? "axes " : "axis ") + axes;
}

// Names what is likely to be wrong with the gyroscope.
std::string cause(const imu::GyroscopeJudgement& judgement) {
    switch (judgement.fault) {
        case imu::GyroscopeFault::Mirrored:
            return "the " + axis_or_axes(judgement.axes) + " of the IMU " +
                   (judgement.axes.size() > 1 ? "are exchanged or mirrored" : "is mirrored");
        case imu::GyroscopeFault::Rotated:
            return "the IMU is not mounted as T_BS says: its " + axis_or_axes(judgement.axes) +
                   " point in other directions";
        case imu::GyroscopeFault::Scaled:
            return "the gyroscope's rates are " + base::fixed(judgement.scale, 2) +
                   " times those of the images: wrong units, a range that is exceeded, or missing "
                   "rows";
        case imu::GyroscopeFault::Biased:
            return "the gyroscope is off by " + base::fixed(judgement.bias_rad_s, 1) +
                   " rad/s all the time: wrong units (degrees/s), or a broken sensor";
        case imu::GyroscopeFault::None:
        case imu::GyroscopeFault::Unexplained: break;
    }
    return "the clocks of cameras and IMU differ by more than " +
           base::fixed(imu::kMaxOffset_s, 0) + " s, or the IMU belongs to another dive";
}

std::string mismatch(const imu::GyroscopeJudgement& judgement) {
    return "the rotations of the gyroscope do not match those of the images (mismatch " +
           percent(std::sqrt(judgement.unexplained_share)) + ")";
}

Finding imu_left_out(const imu::GyroscopeJudgement& judgement) {
    return {
        Severity::Warning,
        "imu_left_out",
        kImuTable,
        mismatch(judgement) + "; likely cause: " + cause(judgement) +
            ". The dive was reconstructed without its IMU",
        "check the IMU's table, its axes and its clock; without it the scale comes from the stereo "
        "baseline alone, unless known distances or pressure measure it too, and the vertical from "
        "the first image, unless the dive has pressure or an AHRS"};
}

double duration_s(const std::vector<types::TimeInterval>& times) {
    double sum_s = 0.0;
    for (const types::TimeInterval& time : times) sum_s += base::to_s(time.to_ns - time.from_ns);
    return sum_s;
}

Finding imu_left_out_for_a_time(const imu::SensorPlan& plan) {
    const std::string duration =
        " for " + base::fixed(duration_s(plan.left_out.imu_times), 0) + " s; likely cause: ";
    const bool explained = plan.gyroscope.fault != imu::GyroscopeFault::None;
    return {Severity::Warning,
            "imu_left_out_for_a_time",
            kImuTable,
            (explained ? mismatch(plan.gyroscope) + duration + cause(plan.gyroscope) + " there"
                       : "the IMU does not match the images" + duration +
                             "noise, a sensor that failed, or rows of another time") +
                ". The IMU was left out for that time",
            "check the rows of the IMU's table at that time"};
}

Finding imu_not_confirmed() {
    return {Severity::Warning,
            "imu_left_out",
            kImuTable,
            "the scene was lost with the IMU's predictions before images could confirm them, "
            "and too little of the dive could be used to test the IMU. The dive was reconstructed "
            "without "
            "its IMU",
            "check the IMU's table, its axes and its clock; turn the rig for some seconds at the "
            "start of a dive"};
}

Finding imu_not_settled() {
    return {
        Severity::Warning,
        "imu_left_out",
        kImuTable,
        "each attempt to track the dive found another error of the IMU; likely cause: its clock "
        "runs at another rate than that of the cameras, or its rows are incomplete. The dive was "
        "reconstructed without its IMU",
        "check the time stamps of the IMU's table"};
}

Finding accelerometer_not_tested() {
    return {Severity::Warning,
            "accelerometer_left_out",
            kImuTable,
            "the scene was lost before six seconds of images, three or more a second, could test "
            "the accelerometer. Only the gyroscope was used",
            "keep the scene in view for some seconds at the start of a dive, and record at least "
            "four pairs a second"};
}

Finding accelerometer_left_out(double disagreement_m_s2) {
    return {Severity::Warning,
            "accelerometer_left_out",
            kImuTable,
            "the gravity that the accelerometer measures rotates with the rig: it moves by " +
                base::fixed(disagreement_m_s2, 1) +
                " m/s^2 (median) while the images' orientation is followed; likely cause: the "
                "accelerometer's axes are not those of the gyroscope, or its units are wrong. Only "
                "the gyroscope was used",
            "check sign, order and units of the accelerometer's columns"};
}

Finding clock_offset(double offset_s) {
    return {Severity::Warning,
            "imu_clock_offset",
            kImuTable,
            "the IMU's clock is " + base::fixed(1000.0 * std::abs(offset_s), 0) + " ms " +
                (offset_s > 0.0 ? "ahead of" : "behind") +
                " that of the cameras. Its rows were shifted by as much",
            "correct the clock, or the table's time stamps"};
}

// Names what is likely to be wrong with the AHRS.
std::string cause(const imu::AhrsJudgement& judgement) {
    const imu::GyroscopeJudgement& rotation = judgement.rotation;
    if (judgement.fault == imu::AhrsFault::Inverse)
        return "its quaternions map the world to the IMU, the inverse of what is asked for";
    if (judgement.fault == imu::AhrsFault::ScalarLast)
        return "w is the last number of its quaternions, not the first";
    if (rotation.fit == imu::GyroscopeFit::FitsShifted)
        return "its clock is " + base::fixed(1000.0 * std::abs(rotation.time_offset_s), 0) +
               " ms " + (rotation.time_offset_s > 0.0 ? "ahead of" : "behind") +
               " that of the cameras";
    if (rotation.fault == imu::GyroscopeFault::Mirrored ||
        rotation.fault == imu::GyroscopeFault::Rotated)
        return "its " + axis_or_axes(rotation.axes) + (rotation.axes.size() > 1 ? " are" : " is") +
               " exchanged or mirrored";
    return "its clock differs from that of the cameras by more than " +
           base::fixed(imu::kMaxOffset_s, 0) +
           " s, it belongs to another dive, or its quaternions are of another convention";
}

Finding ahrs_left_out(const imu::AhrsJudgement& judgement) {
    return {Severity::Warning,
            "ahrs_left_out",
            kAhrsTable,
            "the rotations of the AHRS do not match those of the images (mismatch " +
                percent(std::sqrt(judgement.rotation.unexplained_share)) + "); likely cause: " +
                cause(judgement) + ". The dive was reconstructed without its AHRS",
            "check the order and the sense of the AHRS's quaternions, its axes and its clock"};
}

Finding ahrs_left_out_for_a_time(const imu::SensorPlan& plan) {
    return {Severity::Warning,
            "ahrs_left_out_for_a_time",
            kAhrsTable,
            "the rotations of the AHRS do not match those of the images for " +
                base::fixed(duration_s(plan.left_out.ahrs_times), 0) +
                " s; likely cause: iron near its compass, a sensor that failed, or rows of another "
                "time. The AHRS was left out for that time",
            "check the rows of the AHRS's table at that time"};
}

// Names what is likely to be wrong with the pressure sensor.
std::string cause(const imu::PressureJudgement& judgement) {
    switch (judgement.fault) {
        case imu::PressureFault::Reversed: return "it counts upwards";
        case imu::PressureFault::Scaled: return "its units are wrong, or its range was exceeded";
        case imu::PressureFault::Held:
            return percent(judgement.held_share) +
                   " of its readings stay at one value: its range "
                   "was exceeded, or its port is blocked";
        case imu::PressureFault::Stepped:
        case imu::PressureFault::None:
        case imu::PressureFault::Unexplained: break;
    }
    return "its clock is not that of the cameras, or it belongs to another dive";
}

}  // namespace

std::optional<Finding> imu_noisy(const std::vector<types::ImuSample>& samples,
                                 const types::ImuNoise& stated,
                                 bool accelerometer_used) {
    const types::ImuNoise usual = imu::on_a_diver(stated);
    const types::ImuNoise used = imu::at_least_measured(samples, usual);
    std::string of;
    const auto add = [&](const char* sensor, double usual_density, double density, double sheet) {
        if (density <= usual_density) return;
        of += (of.empty() ? "" : ", ") + std::string(sensor) + " " +
              base::fixed(density / sheet, 0) + " times as much";
    };
    add("gyroscope",
        usual.gyroscope_noise_density,
        used.gyroscope_noise_density,
        stated.gyroscope_noise_density);
    if (accelerometer_used)
        add("accelerometer",
            usual.accelerometer_noise_density,
            used.accelerometer_noise_density,
            stated.accelerometer_noise_density);
    if (of.empty()) return std::nullopt;
    return Finding{Severity::Info,
                   "imu_noisy",
                   kImuTable,
                   "the IMU's rows have more noise than stated or assumed (" + of +
                       "): thrusters, a loose mount, or too few rows for the motion. The larger "
                       "noise was used",
                   "fix the IMU to the cameras, keep it off motors, record all of its rows"};
}

Finding pressure_left_out(const imu::PressureJudgement& judgement) {
    const std::string what =
        judgement.fault == imu::PressureFault::Stepped
            ? "the zero of the pressure sensor moved by " +
                  base::fixed(std::abs(judgement.step_m), 2) +
                  " m at once; likely cause: it was reset, or its port was blocked and came free"
            : "changes of depth by the pressure sensor are " + base::fixed(judgement.scale, 2) +
                  " times those by the images, with an error of " +
                  base::fixed(judgement.error_m, 2) + " m; likely cause: " + cause(judgement);
    return {Severity::Warning,
            "pressure_left_out",
            kPressureTable,
            what + ". The dive was reconstructed without its pressure sensor",
            "check sign, units, range and clock of the pressure sensor's table"};
}

std::vector<Finding> sensor_findings(const imu::SensorPlan& plan) {
    std::vector<Finding> findings;
    if (plan.left_out.ahrs)
        findings.push_back(ahrs_left_out(plan.ahrs));
    else if (!plan.left_out.ahrs_times.empty())
        findings.push_back(ahrs_left_out_for_a_time(plan));
    const bool explained = plan.gyroscope.fault != imu::GyroscopeFault::None;
    if (plan.imu_unconfirmed || plan.left_out.imu) {
        findings.push_back(plan.imu_unsettled                   ? imu_not_settled()
                           : plan.imu_unconfirmed || !explained ? imu_not_confirmed()
                                                                : imu_left_out(plan.gyroscope));
        return findings;
    }
    if (std::abs(plan.alignment.time_offset_s) >= kMinToldOffset_s)
        findings.push_back(clock_offset(plan.alignment.time_offset_s));
    if (!plan.left_out.imu_times.empty()) findings.push_back(imu_left_out_for_a_time(plan));
    if (plan.left_out.accelerometer && !plan.accelerometer_clipped)
        findings.push_back(plan.gravity_disagreement_m_s2 > 0.0
                               ? accelerometer_left_out(plan.gravity_disagreement_m_s2)
                               : accelerometer_not_tested());
    return findings;
}

}  // namespace divemesh::pipeline
