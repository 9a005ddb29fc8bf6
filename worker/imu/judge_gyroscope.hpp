#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "worker/imu/estimate_alignment.hpp"
#include "worker/imu/wrong_times.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::imu {

// The rotation of the body over a span of about a third of a second, long enough that the noise of
// one frame does not matter.
struct RotationSpan {
    std::int64_t from_ns = 0;
    std::int64_t to_ns = 0;
    Eigen::Vector3d rate_body = Eigen::Vector3d::Zero();  // rad/s, by vision alone
};

// Joins rotations that follow each other to spans. A span ends where one rotation does not begin
// when the one before ends.
class RotationSpans {
public:
    void add(const VisionRotation& rotation);
    const std::vector<RotationSpan>& spans() const { return spans_; }

private:
    VisionRotation open_;
    std::vector<RotationSpan> spans_;
};

enum class GyroscopeFit {
    Unknown,      // hardly any rotation, too few spans, or neither of the two below
    Fits,         // with a time offset within kNearOffset_s
    FitsShifted,  // with a larger time offset, up to one second
    Contradicts,
};

// What explains the contradiction between gyroscope and vision.
enum class GyroscopeFault {
    None,
    Unexplained,  // another dive's samples, or an offset of more than a second
    Mirrored,     // `axes`
    Rotated,      // `axes`: not mounted as T_BS says
    Scaled,       // `scale`: units, range or rows that are missing
    Biased,       // `bias_rad_s`: more than any gyroscope has; units, or a broken sensor
};

struct GyroscopeJudgement {
    GyroscopeFit fit = GyroscopeFit::Unknown;
    double time_offset_s = 0.0;  // with which it fits best, as in ImuAlignment
    double unexplained_share =
        0.0;  // of the rotation about the worst axis: 0 fits, 1 is no relation
    GyroscopeFault fault = GyroscopeFault::None;
    std::string axes;    // "z", "x and y"
    double scale = 1.0;  // gyroscope over vision
    double bias_rad_s = 0.0;
};

constexpr double kNearOffset_s = 0.06;  // estimate_alignment() finds such an offset
constexpr double kMaxOffset_s = 1.0;

// Compares the gyroscope with the rotations that vision measured over the last spans, at most 40 of
// them. With the rates v of vision and g of the gyroscope, both less their means (a constant bias
// is no contradiction), the unexplained share of an axis is
//
//     sum (v - R g)^2 / max(sum v^2, sum (R g)^2)
//
// with Huber weights, at the time offset where it is smallest. R is the rotation within 20 degrees
// that fits best (Kabsch, "A solution for the best rotation to relate two sets of vectors", 1976,
// with a prior at no rotation); an axis about which neither rotates counts as explained. `samples`
// are on the cameras' clock and in the body frame as far as both are known. A bias beyond that of
// any gyroscope contradicts after three seconds, all else after five or ten.
GyroscopeJudgement judge_gyroscope(const std::vector<types::ImuSample>& samples,
                                   const std::vector<RotationSpan>& spans);

// Returns the times in which a gyroscope that fits as a whole contradicts vision: v - R g differs
// from its values before and after. Empty if the gyroscope does not fit.
std::vector<types::TimeInterval> wrong_times(const std::vector<types::ImuSample>& samples,
                                             const std::vector<RotationSpan>& spans);

}  // namespace divemesh::imu
