#include "worker/texture/merge_charts.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "worker/base/disjoint_sets.hpp"

namespace divemesh::texture {
namespace {

constexpr int kMaxPasses = 10;

// The triangles of each chart, one chart after the other; ascending within each.
struct Charts {
    std::vector<std::uint32_t> begin;
    std::vector<std::uint32_t> faces;
    std::vector<std::uint32_t> of_face;

    std::size_t num() const { return begin.size() - 1; }
    std::span<const std::uint32_t> of(std::size_t chart) const {
        return {faces.data() + begin[chart], begin[chart + 1] - begin[chart]};
    }
};

Charts charts_of(const FaceGraph& graph, const FaceViews& views) {
    base::DisjointSets sets(views.size());
    for (std::size_t face = 0; face < views.size(); ++face)
        for (const FaceLink& link : graph.links(face))
            if (views[link.face] == views[face]) sets.join(face, link.face);
    Charts charts{{0}, std::vector<std::uint32_t>(views.size()), {}};
    charts.of_face.resize(views.size());
    for (std::size_t face = 0; face < views.size(); ++face) {
        const std::size_t first = sets.find(face);  // the lowest triangle of the chart
        if (first == face) {
            charts.of_face[face] = static_cast<std::uint32_t>(charts.num());
            charts.begin.push_back(0);
        }
        charts.of_face[face] = charts.of_face[first];
        ++charts.begin[charts.of_face[face] + 1];
    }
    std::partial_sum(charts.begin.begin(), charts.begin.end(), charts.begin.begin());
    std::vector<std::uint32_t> next(charts.begin.begin(), charts.begin.end() - 1);
    for (std::size_t face = 0; face < views.size(); ++face)
        charts.faces[next[charts.of_face[face]]++] = static_cast<std::uint32_t>(face);
    return charts;
}

// What a chart would cost with another view.
struct ViewSums {
    double cost_m2 = 0.0;     // of its triangles
    std::size_t num = 0;      // of its triangles that have this candidate
    double no_seam_m2 = 0.0;  // along neighbouring charts that have this view
};

// Moves charts to better views, one at a time.
class ChartMover {
public:
    ChartMover(const ViewField& field, const Charts& charts, FaceViews& views)
        : field_(field), charts_(charts), views_(views), sums_(kNumViews) {}

    // Returns true if the chart has another view afterwards.
    bool move(std::size_t chart) {
        const std::int32_t view = views_[charts_.of(chart).front()];
        if (view == kNoView) return false;
        sum_up(chart);
        const std::int32_t best = best_view(charts_.of(chart).size(), view);
        for (const std::uint16_t used : used_) sums_[used] = {};
        used_.clear();
        if (best == view) return false;
        for (const std::uint32_t face : charts_.of(chart)) views_[face] = best;
        return true;
    }

private:
    static constexpr std::size_t kNumViews = 1U + std::numeric_limits<std::uint16_t>::max();

    ViewSums& sums_of(std::int32_t view) {
        ViewSums& sums = sums_[static_cast<std::size_t>(view)];
        if (sums.num == 0 && sums.no_seam_m2 == 0.0)
            used_.push_back(static_cast<std::uint16_t>(view));
        return sums;
    }

    void sum_up(std::size_t chart) {
        for (const std::uint32_t face : charts_.of(chart)) {
            field_.for_each_view(face, [&](std::uint16_t view, float cost) {
                ViewSums& sums = sums_of(view);
                sums.cost_m2 += static_cast<double>(cost);
                ++sums.num;
            });
            for (const FaceLink& link : field_.graph.links(face))
                if (charts_.of_face[link.face] != chart && views_[link.face] != kNoView)
                    sums_of(views_[link.face]).no_seam_m2 +=
                        static_cast<double>(field_.seam_cost(link));
        }
    }

    // Returns the view of least energy, the lowest of equals; the present one unless it is worse.
    std::int32_t best_view(std::size_t num_faces, std::int32_t present) {
        std::sort(used_.begin(), used_.end());
        const auto energy = [&](std::int32_t view) {
            const ViewSums& sums = sums_[static_cast<std::size_t>(view)];
            return sums.cost_m2 - sums.no_seam_m2;
        };
        std::int32_t best = present;
        for (const std::uint16_t view : used_)
            if (sums_[view].num == num_faces && energy(view) < energy(best)) best = view;
        return best;
    }

    const ViewField& field_;
    const Charts& charts_;
    FaceViews& views_;
    std::vector<ViewSums> sums_;       // by view
    std::vector<std::uint16_t> used_;  // views whose sums are not zero
};

}  // namespace

void merge_charts(const ViewField& field, FaceViews& views) {
    bool has_changed = !views.empty();
    for (int i = 0; i < kMaxPasses && has_changed; ++i) {
        const Charts charts = charts_of(field.graph, views);
        ChartMover mover(field, charts, views);
        has_changed = false;
        for (std::size_t chart = 0; chart < charts.num(); ++chart)
            has_changed = mover.move(chart) || has_changed;
    }
}

}  // namespace divemesh::texture
