#include "worker/compare/colonies.hpp"

#include <algorithm>

namespace divemesh::compare {
namespace {

constexpr double kMinOverlapShare = 0.25;  // of the smaller outline

// Returns the overlap. The signed triangles of a fan about q's first corner add up to q.
double in_common_m2(const reef::Polygon& p, const reef::Polygon& q) {
    double sum = 0.0;
    double rotation = 0.0;
    for (std::size_t i = 1; i + 1 < q.size(); ++i) {
        const Eigen::Vector2d u = q[i] - q[0];
        const Eigen::Vector2d v = q[i + 1] - q[0];
        const double twice = u.x() * v.y() - u.y() * v.x();
        rotation += twice;
        if (twice > 0.0) sum += reef::overlap_m2(p, q[0], q[i], q[i + 1]);
        if (twice < 0.0) sum -= reef::overlap_m2(p, q[0], q[i + 1], q[i]);
    }
    return rotation < 0.0 ? -sum : sum;
}

Eigen::AlignedBox2d box_of(const reef::Polygon& outline) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& p : outline) box.extend(p);
    return box;
}

struct Candidate {
    ColonyPair pair;
    double in_common_m2 = 0.0;
};

std::vector<Candidate> candidates(const std::vector<Colony>& before,
                                  const std::vector<Colony>& after) {
    const auto boxes_of = [](const std::vector<Colony>& colonies) {
        std::vector<Eigen::AlignedBox2d> boxes;
        boxes.reserve(colonies.size());
        for (const Colony& colony : colonies) boxes.push_back(box_of(colony.outline));
        return boxes;
    };
    const auto boxes_before = boxes_of(before);
    const auto boxes_after = boxes_of(after);
    std::vector<Candidate> found;
    for (std::size_t i = 0; i < before.size(); ++i)
        for (std::size_t k = 0; k < after.size(); ++k) {
            const Colony& p = before[i];
            const Colony& q = after[k];
            if (!boxes_before[i].intersects(boxes_after[k]) || p.label != q.label) continue;
            const double common = in_common_m2(p.outline, q.outline);
            if (common >= kMinOverlapShare * std::min(p.area_m2, q.area_m2))
                found.push_back({{static_cast<int>(i), static_cast<int>(k)}, common});
        }
    std::ranges::stable_sort(found, [](const Candidate& p, const Candidate& q) {
        return p.in_common_m2 > q.in_common_m2;
    });
    return found;
}

}  // namespace

std::vector<Colony> colonies_of(const reef::AreaSet& set,
                                const RasterGrid& grid,
                                const cv::Mat& ground) {
    std::vector<Colony> colonies;
    for (const reef::Area& area : set.areas) {
        if (area.label.empty() || area.kind == reef::AreaKind::Transect) continue;
        Colony colony{area.name, area.label, outline_from_above(area)};
        colony.area_m2 = reef::area_m2(colony.outline);
        colony.diameter_m = reef::max_diameter_m(colony.outline);
        colony.share =
            share_on(cells_within(colony.outline, grid), colony.area_m2, ground, grid.cell_m);
        colonies.push_back(std::move(colony));
    }
    return colonies;
}

std::vector<ColonyPair> match_colonies(const std::vector<Colony>& before,
                                       const std::vector<Colony>& after) {
    std::vector<ColonyPair> pairs(before.size());
    std::vector<bool> taken(after.size(), false);
    for (std::size_t i = 0; i < before.size(); ++i) pairs[i].before = static_cast<int>(i);
    for (const Candidate& candidate : candidates(before, after)) {
        ColonyPair& pair = pairs[static_cast<std::size_t>(candidate.pair.before)];
        const auto k = static_cast<std::size_t>(candidate.pair.after);
        if (pair.after >= 0 || taken[k]) continue;
        pair.after = candidate.pair.after;
        taken[k] = true;
    }
    for (std::size_t k = 0; k < after.size(); ++k)
        if (!taken[k]) pairs.push_back({-1, static_cast<int>(k)});
    return pairs;
}

}  // namespace divemesh::compare
