#include "worker/imu/judge_ahrs.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"

namespace divemesh::imu {
namespace {

constexpr std::size_t kSpansOfPart = 40;
constexpr std::int64_t kMaxGap_ns = 300'000'000;  // over a longer one the rate is not constant
constexpr std::int64_t kStep_ns = 10'000'000;
// A rotation that is none of the rig's leaves one or more unexplained; the noise of an AHRS, which
// changes from one orientation to the next as a gyroscope's angle does not, less than a quarter.
constexpr double kContradicts = 0.5;

using Orientations = std::vector<types::OrientationSample>;

// Returns what a gyroscope would have measured, with constant rates between two orientations.
std::vector<types::ImuSample> rates_of(const Orientations& orientations) {
    std::vector<types::ImuSample> samples;
    for (std::size_t i = 1; i < orientations.size(); ++i) {
        const types::OrientationSample& before = orientations[i - 1];
        const types::OrientationSample& after = orientations[i];
        const std::int64_t interval_ns = after.timestamp_ns - before.timestamp_ns;
        if (interval_ns <= 0 || interval_ns > kMaxGap_ns) continue;
        const Eigen::Vector3d rate =
            base::vector_from_rotation(before.q_world_imu.conjugate() * after.q_world_imu) /
            base::to_s(interval_ns);
        const std::int64_t num = 1 + interval_ns / kStep_ns;
        for (std::int64_t k = 0; k < num; ++k)
            samples.push_back({before.timestamp_ns + (2 * k + 1) * interval_ns / (2 * num),
                               rate,
                               Eigen::Vector3d::Zero()});
    }
    return samples;
}

// How many parts of the dive fit, and how many do not.
struct Parts {
    int num_fitting = 0;
    int num_contradicting = 0;
    GyroscopeJudgement first;  // of those that contradict

    bool contradict() const { return num_contradicting > num_fitting; }
    bool fit() const { return num_fitting > num_contradicting; }
};

Parts judge_parts(const Orientations& orientations, const std::vector<RotationSpan>& spans) {
    const std::vector<types::ImuSample> samples = rates_of(orientations);
    Parts parts;
    for (std::size_t end = spans.size(); end > 0; end -= std::min(end, kSpansOfPart)) {
        const auto last = spans.begin() + static_cast<std::ptrdiff_t>(end);
        const auto judgement = judge_gyroscope(
            samples, {last - static_cast<std::ptrdiff_t>(std::min(end, kSpansOfPart)), last});
        if (judgement.fit == GyroscopeFit::Fits) ++parts.num_fitting;
        const bool contradicts = judgement.fit == GyroscopeFit::FitsShifted ||
                                 (judgement.fit == GyroscopeFit::Contradicts &&
                                  judgement.unexplained_share > kContradicts);
        if (!contradicts) continue;
        ++parts.num_contradicting;
        parts.first = judgement;
    }
    return parts;
}

// Returns the fault in writing quaternions that explains the contradiction.
std::optional<AhrsFault> fault_of_writing(const Orientations& orientations,
                                          const std::vector<RotationSpan>& spans) {
    const auto judged = [&](const auto& change) {
        Orientations changed = orientations;
        for (types::OrientationSample& sample : changed)
            sample.q_world_imu = change(sample.q_world_imu);
        return judge_parts(changed, spans);
    };
    const Parts inverse = judged([](const Eigen::Quaterniond& q) { return q.conjugate(); });
    if (inverse.fit()) return AhrsFault::Inverse;
    // Read as w x y z, though x y z w were written.
    const Parts scalar_last = judged(
        [](const Eigen::Quaterniond& q) { return Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y()); });
    if (scalar_last.fit()) return AhrsFault::ScalarLast;
    return std::nullopt;
}

}  // namespace

AhrsJudgement judge_ahrs(const Orientations& orientations, const std::vector<RotationSpan>& spans) {
    const Parts parts = judge_parts(orientations, spans);
    if (!parts.contradict())
        return {AhrsFault::None, parts.first, wrong_times(rates_of(orientations), spans)};
    return {
        fault_of_writing(orientations, spans).value_or(AhrsFault::AsGyroscope), parts.first, {}};
}

}  // namespace divemesh::imu
