#include "worker/evaluation/revisit_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/stats/summary.hpp"

namespace divemesh::evaluation {
namespace {

constexpr std::int64_t kMinRevisitInterval_ns = 10'000'000'000;
constexpr double kReach_m = 0.5;
constexpr double kMaxRotation_rad = 0.7853981633974483;

// The earlier poses, indexed by true position in cubes of kReach_m.
class VisitedPlaces {
public:
    explicit VisitedPlaces(const std::vector<PosePair>& pairs) : pairs_(pairs) {}

    void add(std::size_t index) { cells_[cell_of(position(index))].push_back(index); }

    std::optional<std::size_t> nearest(std::size_t index) const {
        std::optional<std::size_t> best;
        double min_m = kReach_m;
        const Cell centre = cell_of(position(index));
        for (int i = 0; i < 27; ++i) {
            const auto cell = cells_.find(
                {centre[0] + i % 3 - 1, centre[1] + i / 3 % 3 - 1, centre[2] + i / 9 - 1});
            if (cell == cells_.end()) continue;
            for (const std::size_t other : cell->second) {
                const double distance_m = (position(other) - position(index)).norm();
                if (distance_m >= min_m || rotation_rad(other, index) > kMaxRotation_rad) continue;
                min_m = distance_m;
                best = other;
            }
        }
        return best;
    }

private:
    using Cell = std::array<long, 3>;

    Eigen::Vector3d position(std::size_t index) const {
        return pairs_[index].T_reference_body.translation();
    }
    double rotation_rad(std::size_t a, std::size_t b) const {
        return base::angle_rad(pairs_[a].T_reference_body.linear().transpose() *
                               pairs_[b].T_reference_body.linear());
    }
    static Cell cell_of(const Eigen::Vector3d& point) {
        const Eigen::Vector3d cell = (point / kReach_m).array().floor();
        return {std::lround(cell.x()), std::lround(cell.y()), std::lround(cell.z())};
    }

    const std::vector<PosePair>& pairs_;
    std::map<Cell, std::vector<std::size_t>> cells_;
};

}  // namespace

std::optional<RevisitError> revisit_error(const std::vector<PosePair>& pairs) {
    VisitedPlaces visited(pairs);
    std::vector<double> translations_m;
    std::vector<double> rotations_deg;
    std::size_t num_visited = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        while (pairs[num_visited].timestamp_ns + kMinRevisitInterval_ns <= pairs[i].timestamp_ns)
            visited.add(num_visited++);
        const auto before = visited.nearest(i);
        if (!before) continue;
        const Eigen::Isometry3d truth =
            pairs[*before].T_reference_body.inverse() * pairs[i].T_reference_body;
        const Eigen::Isometry3d estimate =
            pairs[*before].T_world_body.inverse() * pairs[i].T_world_body;
        translations_m.push_back((truth.translation() - estimate.translation()).norm());
        rotations_deg.push_back(base::kDegPerRad *
                                base::angle_rad(truth.linear().transpose() * estimate.linear()));
    }
    if (translations_m.empty()) return std::nullopt;
    return RevisitError{static_cast<std::int64_t>(translations_m.size()),
                        stats::root_mean_square(translations_m),
                        *std::max_element(translations_m.begin(), translations_m.end()),
                        stats::root_mean_square(rotations_deg)};
}

}  // namespace divemesh::evaluation
