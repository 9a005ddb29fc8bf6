#include "worker/dive/ahrs_jumps.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>

#include "worker/base/angle.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMinJump_rad = 5.0 * base::kRadPerDeg;
constexpr double kMinRate_rad_s = 4.0;
constexpr double kMinTimes = 10.0;  // the usual angle between two rows
constexpr std::size_t kMaxJumps = 20;

// The jump from the row before to `row`.
struct Jump {
    std::size_t row = 0;
    double angle_rad = 0.0;
};

// Returns the angle from each row to the next.
std::vector<double> angles_of(const std::vector<types::OrientationSample>& samples) {
    std::vector<double> angles_rad;
    for (std::size_t i = 1; i < samples.size(); ++i)
        angles_rad.push_back(samples[i - 1].q_world_imu.angularDistance(samples[i].q_world_imu));
    return angles_rad;
}

std::vector<Jump> jumps_of(const std::vector<types::OrientationSample>& samples) {
    const std::vector<double> angles_rad = angles_of(samples);
    const double min_rad = std::max(kMinJump_rad, kMinTimes * stats::median(angles_rad));
    std::vector<Jump> jumps;
    for (std::size_t i = 1; i < samples.size(); ++i) {
        const double interval_s = base::to_s(samples[i].timestamp_ns - samples[i - 1].timestamp_ns);
        if (angles_rad[i - 1] > std::max(min_rad, kMinRate_rad_s * interval_s))
            jumps.push_back({i, angles_rad[i - 1]});
    }
    return jumps;
}

}  // namespace

void take_off_ahrs_jumps(std::vector<types::OrientationSample>& samples,
                         const std::string& file,
                         FindingLog& findings) {
    const std::vector<Jump> jumps = jumps_of(samples);
    if (jumps.empty() || jumps.size() > kMaxJumps) return;
    const Jump& largest = *std::ranges::max_element(jumps, {}, &Jump::angle_rad);
    findings.warning("ahrs_jump",
                     file,
                     "the orientation jumps " + std::to_string(jumps.size()) +
                         (jumps.size() == 1 ? " time" : " times") + ", by up to " +
                         base::fixed(base::kDegPerRad * largest.angle_rad, 0) + " degrees at " +
                         std::to_string(samples[largest.row].timestamp_ns) +
                         ". The rows after a jump were turned back by as much",
                     "Do not reset the AHRS during a dive, and keep it away from iron.");
    // The rig turns little between two rows, so the row before a jump tells the one after it.
    Eigen::Quaterniond q_first_now = Eigen::Quaterniond::Identity();  // of the AHRS's worlds
    auto jump = jumps.begin();
    Eigen::Quaterniond q_before = samples.front().q_world_imu;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        Eigen::Quaterniond& q = samples[i].q_world_imu;
        if (jump != jumps.end() && jump->row == i) {
            q_first_now = (q_before * q.conjugate()).normalized();
            ++jump;
        }
        q = (q_first_now * q).normalized();
        q_before = q;
    }
}

}  // namespace divemesh::dive
