#include "worker/optimisation/anchored_path.hpp"

#include <algorithm>
#include <utility>

namespace divemesh::optimisation {
namespace {

// Returns true if a motion after `from_ns` and up to `to_ns` was not measured.
bool is_broken(const types::Breaks& breaks_ns, std::int64_t from_ns, std::int64_t to_ns) {
    const auto next = std::ranges::upper_bound(breaks_ns, from_ns);
    return next != breaks_ns.end() && *next <= to_ns;
}

}  // namespace

AnchoredPath::AnchoredPath(std::vector<std::int64_t> timestamps_ns,
                           std::vector<Eigen::Isometry3d> T_world_imu,
                           const types::Breaks& breaks_ns)
    : timestamps_ns_(std::move(timestamps_ns)),
      T_world_imu_(std::move(T_world_imu)),
      breaks_ns_(breaks_ns) {
    for (std::size_t i = 0; i < timestamps_ns_.size(); ++i) {
        const bool begins =
            i == 0 || is_broken(breaks_ns_, timestamps_ns_[i - 1], timestamps_ns_[i]);
        first_of_run_.push_back(begins ? i : first_of_run_.back());
    }
}

AnchoredPath::Place AnchoredPath::at(std::int64_t timestamp_ns) const {
    const auto after = static_cast<std::size_t>(
        std::ranges::upper_bound(timestamps_ns_, timestamp_ns) - timestamps_ns_.begin());
    if (after == 0) return {0, 0, 0.0};
    const std::size_t a = after - 1;
    if (after == size()) return {a, a, 0.0};
    if (first_of_run_[after] == after) {
        const std::size_t nearer =
            is_broken(breaks_ns_, timestamps_ns_[a], timestamp_ns) ? after : a;
        return {nearer, nearer, 0.0};
    }
    return {a,
            after,
            static_cast<double>(timestamp_ns - timestamps_ns_[a]) /
                static_cast<double>(timestamps_ns_[after] - timestamps_ns_[a])};
}

Eigen::Isometry3d corrected(const AnchoredPath& path,
                            const std::vector<Eigen::Isometry3d>& T_new_old,
                            std::int64_t timestamp_ns,
                            const Eigen::Isometry3d& T_old_body) {
    const AnchoredPath::Place place = path.at(timestamp_ns);
    const Eigen::Isometry3d& A = T_new_old[place.a];
    const Eigen::Isometry3d& B = T_new_old[place.b];
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(A.linear()).slerp(place.weight_b, Eigen::Quaterniond(B.linear()));
    const Eigen::Vector3d p = T_old_body.translation();
    Eigen::Isometry3d T_new_body;
    T_new_body.linear() = q.toRotationMatrix() * T_old_body.linear();
    T_new_body.translation() = (1.0 - place.weight_b) * (A * p) + place.weight_b * (B * p);
    T_new_body.makeAffine();
    return T_new_body;
}

}  // namespace divemesh::optimisation
