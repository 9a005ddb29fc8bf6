#include "worker/simulator/surface_change.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "worker/base/disjoint_sets.hpp"
#include "worker/simulator/ray_caster.hpp"

namespace divemesh::simulator {
namespace {

constexpr float kMinChange_m = 0.001F;
constexpr float kAbove_m = 50.0F;

using Cell = std::pair<int, int>;  // row, column: multiples of the cell size in the world

struct ChangedCell {
    float change_m = 0.0F;
    std::vector<std::size_t> objects;  // indices in Scene::changes
};

int cell_index(float place_m) {
    return static_cast<int>(std::floor(static_cast<double>(place_m) / kSurfaceChangeCell_m));
}

double cell_center(int index) { return (index + 0.5) * kSurfaceChangeCell_m; }

std::map<Cell, ChangedCell> cells_of(const std::vector<SceneChange>& changes) {
    std::map<Cell, ChangedCell> cells;
    for (std::size_t i = 0; i < changes.size(); ++i) {
        const auto box = changes[i].before_world.merged(changes[i].after_world);
        for (int row = cell_index(box.min().y()); row <= cell_index(box.max().y()); ++row)
            for (int column = cell_index(box.min().x()); column <= cell_index(box.max().x());
                 ++column)
                cells[{row, column}].objects.push_back(i);
    }
    return cells;
}

// Returns a constant minus the height of the highest surface; cells without surface are 0 in both
// scenes and so do not change.
float depth_below(const RayCaster& caster, const Cell& cell) {
    const Eigen::Vector3f above(static_cast<float>(cell_center(cell.second)),
                                static_cast<float>(cell_center(cell.first)),
                                kAbove_m);
    const RayHit hit = caster.cast(above, -Eigen::Vector3f::UnitZ());
    return hit.valid() ? hit.t : 0.0F;
}

}  // namespace

std::vector<SurfaceChange> surface_changes(const Scene& before, const Scene& after) {
    const RayCaster caster_before(before.vertices, before.triangles);
    const RayCaster caster_after(after.vertices, after.triangles);
    std::map<Cell, ChangedCell> cells = cells_of(after.changes);
    for (auto& [cell, changed] : cells)
        changed.change_m = depth_below(caster_before, cell) - depth_below(caster_after, cell);
    std::erase_if(cells,
                  [](const auto& entry) { return std::abs(entry.second.change_m) < kMinChange_m; });
    std::map<Cell, std::size_t> number;
    for (const auto& [cell, changed] : cells) number.emplace(cell, number.size());
    base::DisjointSets sets(cells.size());
    for (const auto& [cell, index] : number)
        for (const Cell& step : {Cell{0, 1}, Cell{1, -1}, Cell{1, 0}, Cell{1, 1}}) {
            const auto next = number.find({cell.first + step.first, cell.second + step.second});
            if (next != number.end() &&
                (cells.at(cell).change_m > 0.0F) == (cells.at(next->first).change_m > 0.0F))
                sets.join(index, next->second);
        }
    std::map<std::size_t, SurfaceChange> changes;
    for (const auto& [cell, changed] : cells) {
        SurfaceChange& change = changes[sets.find(number.at(cell))];
        const double cell_m2 = kSurfaceChangeCell_m * kSurfaceChangeCell_m;
        change.grown = changed.change_m > 0.0F;
        change.area_m2 += cell_m2;
        change.volume_m3 += cell_m2 * std::abs(static_cast<double>(changed.change_m));
        change.box_world.extend(Eigen::Vector2d(cell_center(cell.second), cell_center(cell.first)));
        for (const std::size_t object : changed.objects)
            if (const auto& name = after.changes[object].name;
                std::ranges::find(change.names, name) == change.names.end())
                change.names.push_back(name);
    }
    std::vector<SurfaceChange> result;
    result.reserve(changes.size());
    for (auto& [set, change] : changes) result.push_back(std::move(change));
    return result;
}

}  // namespace divemesh::simulator
