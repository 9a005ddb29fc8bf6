#include "worker/mesh/simplify_within.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "worker/base/parallel.hpp"
#include "worker/base/part_of.hpp"
#include "worker/base/radix_sort.hpp"
#include "worker/mesh/mesh_components.hpp"
#include "worker/mesh/simplify_group.hpp"

namespace divemesh::mesh {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Triangles are simplified in groups: the cells of a lattice over the three axes and the logarithm
// of the tolerance. Each group is simplified to its smallest tolerance while its border stays. The
// second pass shifts the lattice by half a cell along all four, where the border of the first was.
constexpr double kPassShifts[] = {0.0, 0.5};
// Both passes together must stay within the tolerance.
constexpr double kToleranceOfPass = 0.5;
// Limits the rounding errors of meshoptimizer's quadrics, which are floats over the extent of the
// group: some sqrt(2^-24) of it.
constexpr double kCellSide_tolerances = 256.0;

// Shares of a pass that are done.
constexpr double kSplit = 0.1;
constexpr double kSimplified = 0.9;
// These take one thread some 50 ms.
constexpr std::size_t kSlice_triangles = 50'000;

// Groups of fewer triangles are not divided.
constexpr std::size_t kMinDivided_triangles = 32;

// A cell of the lattice as one number, so that triangles can be sorted by it.
using CellKey = std::uint64_t;
constexpr CellKey kNotSimplified = std::numeric_limits<CellKey>::max();

CellKey bits_of(double index, int num_bits) {
    const double half = std::ldexp(1.0, num_bits - 1);
    return static_cast<CellKey>(std::clamp(std::floor(index), -half, half - 2.0) + half);
}

CellKey cell_of(const Eigen::Vector3f& p_world, float tolerance_m, double shift) {
    if (!(tolerance_m > 0.0F) || !std::isfinite(tolerance_m)) return kNotSimplified;
    const double level = std::floor(std::log2(tolerance_m) + shift);
    const double side_m = kCellSide_tolerances * std::exp2(level - shift);
    CellKey key = bits_of(level, 7);
    for (const float coordinate_m : p_world)
        key = (key << 19) | bits_of(coordinate_m / side_m + shift, 19);
    return key;
}

struct KeyedTriangle {
    CellKey cell;
    std::uint32_t triangle;
};

// A group of triangles, before and after.
struct Group {
    std::vector<Triangle> triangles;
    double max_error_m = 0.0;
    std::optional<SimplifiedGroup> simplified;
};

// An edge at the border of a group, or between two vertices of it.
struct OuterEdge {
    std::array<std::uint32_t, 2> vertices;
    bool may_be_new;  // a chord of a group that was simplified
    std::size_t group;
    auto operator<=>(const OuterEdge&) const = default;
};

// Calls use(edge) for the edges at the borders of all groups and between two vertices of them.
template <typename Use>
void for_each_outer_edge(const std::vector<Group>& groups, const Use& use) {
    for (std::size_t i = 0; i < groups.size(); ++i) {
        if (!groups[i].simplified) continue;
        for (const auto& edge : groups[i].simplified->border) use(OuterEdge{edge, false, i});
        for (const auto& edge : groups[i].simplified->chords)
            use(OuterEdge{edge, groups[i].max_error_m > 0.0, i});
    }
}

// Returns the outer edges, sorted: at first by their lower vertex, which few edges share.
std::vector<OuterEdge> outer_edges(const std::vector<Group>& groups, std::size_t num_vertices) {
    std::vector<std::size_t> end(num_vertices + 1, 0);
    for_each_outer_edge(groups, [&](const OuterEdge& edge) { ++end[edge.vertices[0] + 1]; });
    std::partial_sum(end.begin(), end.end(), end.begin());
    std::vector<OuterEdge> edges(end.back());
    for_each_outer_edge(groups,
                        [&](const OuterEdge& edge) { edges[end[edge.vertices[0]]++] = edge; });
    auto begin = edges.begin();
    for (std::size_t vertex = 0; vertex < num_vertices; ++vertex) {
        const auto next = edges.begin() + static_cast<std::ptrdiff_t>(end[vertex]);
        std::sort(begin, next);
        begin = next;
    }
    return edges;
}

// Discards the result of groups whose collapses made an edge that another group has as well.
void discard_conflicts(std::vector<Group>& groups, std::size_t num_vertices) {
    const std::vector<OuterEdge> edges = outer_edges(groups, num_vertices);
    for (std::size_t i = 1; i < edges.size(); ++i)
        if (edges[i].vertices == edges[i - 1].vertices && edges[i].may_be_new)
            groups[edges[i].group].simplified.reset();
}

// Moves the half of the triangles that is farther along the longest axis to another group. A group
// that is too small to be divided keeps all of its triangles from now on.
std::optional<Group> divide(Group& group, const std::vector<Eigen::Vector3f>& vertices) {
    if (group.triangles.size() < kMinDivided_triangles) {
        group.max_error_m = 0.0;
        return std::nullopt;
    }
    Eigen::AlignedBox3f box;
    for (const Triangle& triangle : group.triangles) box.extend(vertices[triangle[0]]);
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const auto middle =
        group.triangles.begin() + static_cast<std::ptrdiff_t>(group.triangles.size() / 2);
    const auto is_before = [&](const Triangle& a, const Triangle& b) {
        const float a_m = vertices[a[0]][axis];
        const float b_m = vertices[b[0]][axis];
        return a_m != b_m ? a_m < b_m : a < b;
    };
    std::nth_element(group.triangles.begin(), middle, group.triangles.end(), is_before);
    Group half{{middle, group.triangles.end()}, group.max_error_m, std::nullopt};
    group.triangles.erase(middle, group.triangles.end());
    return half;
}

class Simplification {
public:
    Simplification(const types::Mesh& mesh, const std::vector<float>& tolerance_m, int num_threads)
        : mesh_(mesh),
          tolerance_m_(tolerance_m),
          num_threads_(num_threads),
          triangles_(mesh.triangles) {}

    void run_pass(double shift, const base::ProgressCallback& progress) {
        std::vector<Group> groups = split(shift, {.end = kSplit, .report = progress});
        simplify(groups, {.begin = kSplit, .end = kSimplified, .report = progress});
        while (divide_failed(groups))
            simplify(groups, {.begin = kSimplified, .end = kSimplified, .report = progress});
        triangles_.clear();
        for (const Group& group : groups)
            triangles_.insert(triangles_.end(),
                              group.simplified->triangles.begin(),
                              group.simplified->triangles.end());
    }

    std::vector<Triangle> take_triangles() { return std::move(triangles_); }

private:
    // Returns the lowest tolerance of the corners; not a number if one of them is not.
    float tolerance_of(const Triangle& triangle) const {
        float lowest_m = tolerance_m_[triangle[0]];
        for (const std::uint32_t vertex : triangle)
            if (!(tolerance_m_[vertex] >= lowest_m)) lowest_m = tolerance_m_[vertex];
        return lowest_m;
    }

    std::vector<KeyedTriangle> sort_triangles(double shift,
                                              const base::ProgressShare& progress) const {
        std::vector<KeyedTriangle> keyed(triangles_.size());
        base::for_each_index(num_threads_, keyed.size(), progress, [&](std::size_t i) {
            const Triangle& triangle = triangles_[i];
            keyed[i] = {cell_of(mesh_.vertices[triangle[0]], tolerance_of(triangle), shift),
                        static_cast<std::uint32_t>(i)};
        });
        base::radix_sort(
            keyed,
            [](const KeyedTriangle& triangle) { return triangle.cell; },
            [&] { progress.at(1.0); });
        return keyed;
    }

    std::vector<Group> split(double shift, const base::ProgressShare& progress) const {
        std::vector<Group> groups;
        CellKey cell = kNotSimplified;
        for (const KeyedTriangle& keyed : sort_triangles(shift, progress)) {
            const Triangle& triangle = triangles_[keyed.triangle];
            const double max_error_m =
                keyed.cell == kNotSimplified ? 0.0 : kToleranceOfPass * tolerance_of(triangle);
            if (groups.empty() || keyed.cell != cell)
                groups.push_back({{}, max_error_m, std::nullopt});
            cell = keyed.cell;
            groups.back().triangles.push_back(triangle);
            groups.back().max_error_m = std::min(groups.back().max_error_m, max_error_m);
        }
        return groups;
    }

    // Simplifies the groups without a result, some kSlice_triangles between two reports.
    void simplify(std::vector<Group>& groups, const base::ProgressShare& progress) const {
        for (std::size_t begin = 0; begin < groups.size();) {
            progress.at(static_cast<double>(begin) / static_cast<double>(groups.size()));
            std::vector<Group*> slice;
            for (std::size_t num = 0; begin < groups.size() && num < kSlice_triangles; ++begin) {
                if (groups[begin].simplified) continue;
                slice.push_back(&groups[begin]);
                num += groups[begin].triangles.size();
            }
            base::for_each_index(num_threads_, slice.size(), [&](std::size_t i) {
                Group& group = *slice[i];
                group.simplified =
                    simplify_group(mesh_.vertices, group.triangles, group.max_error_m);
            });
        }
        progress.at(1.0);
        discard_conflicts(groups, mesh_.vertices.size());
        progress.at(1.0);
    }

    // Divides the groups that have no result. Returns whether there were any.
    bool divide_failed(std::vector<Group>& groups) const {
        bool has_failed = false;
        for (std::size_t i = 0, num = groups.size(); i < num; ++i) {
            if (groups[i].simplified) continue;
            has_failed = true;
            if (auto half = divide(groups[i], mesh_.vertices)) groups.push_back(std::move(*half));
        }
        return has_failed;
    }

    const types::Mesh& mesh_;
    const std::vector<float>& tolerance_m_;
    int num_threads_;
    std::vector<Triangle> triangles_;
};

}  // namespace

types::Mesh simplify_within(const types::Mesh& mesh,
                            const std::vector<float>& tolerance_m,
                            int num_threads,
                            const base::ProgressCallback& progress) {
    Simplification simplification(mesh, tolerance_m, num_threads);
    constexpr double kNumPasses = std::size(kPassShifts);
    for (std::size_t i = 0; i < std::size(kPassShifts); ++i) {
        const auto num_before = static_cast<double>(i);
        simplification.run_pass(
            kPassShifts[i],
            base::part_of(progress, num_before / kNumPasses, (num_before + 1.0) / kNumPasses));
    }
    types::Mesh simplified = mesh;
    simplified.triangles = simplification.take_triangles();
    remove_unreferenced_vertices(simplified);
    return simplified;
}

}  // namespace divemesh::mesh
