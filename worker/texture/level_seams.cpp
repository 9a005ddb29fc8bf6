#include "worker/texture/level_seams.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <numeric>

#include "worker/stats/robust.hpp"
#include "worker/texture/level_gains.hpp"
#include "worker/texture/solve_smooth_system.hpp"

namespace divemesh::texture {
namespace {

constexpr double kSmoothness = 1.0;  // of a triangle's side over the end of a seam
// To 0, per vertex. Fixes the mean, and ends what a seam adds some 30 triangles away from it, so
// that errors of the steps do not add up over many seams.
constexpr double kPull = 1e-3;

// The step of the colours at one end of a seam.
struct SeamEnd {
    std::array<std::size_t, 2> vertices = {};        // numbers in both keyframes
    Eigen::Vector3d step = Eigen::Vector3d::Zero();  // second side - first side
};

SeamEnd seam_end(const SeamColors& colors,
                 const Seam& seam,
                 std::size_t end,
                 const Levelling& levelling) {
    SeamEnd result;
    for (std::size_t side = 0; side < 2; ++side)
        result.vertices[side] =
            levelling.vertices.number(seam.edge.vertices[end], seam.keyframes[side]);
    float sum_of_weights = 0.0F;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::uint32_t i = 0; i < seam.num_samples; ++i) {
        const float weight = end == 0 ? 1.0F - seam.along(i) : seam.along(i);
        sum += weight * (levelling.gains[seam.keyframes[1]].cwiseProduct(colors.color(seam, 1, i)) -
                         levelling.gains[seam.keyframes[0]].cwiseProduct(colors.color(seam, 0, i)));
        sum_of_weights += weight;
    }
    result.step = (sum / sum_of_weights).cast<double>();
    return result;
}

// Returns how much a step counts: little where the surface is not where it should be, or something
// swam past.
double weight_of(const Eigen::Vector3d& step) {
    return stats::tukey_weight(step.cwiseAbs().maxCoeff(), kMaxStep);
}

// The normal equations: lower triangle, and a right side per channel.
struct LevellingSystem {
    std::vector<Eigen::Triplet<double>> lower;
    Eigen::MatrixX3d right;

    explicit LevellingSystem(std::size_t num)
        : right(Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(num), 3)) {}

    // Adds weight * (x_a - x_b - difference)^2.
    void add(std::size_t a, std::size_t b, double weight, const Eigen::Vector3d& difference) {
        const auto row = static_cast<int>(std::max(a, b));
        const auto column = static_cast<int>(std::min(a, b));
        lower.emplace_back(row, row, weight);
        lower.emplace_back(column, column, weight);
        lower.emplace_back(row, column, -weight);
        right.row(static_cast<Eigen::Index>(a)) += weight * difference;
        right.row(static_cast<Eigen::Index>(b)) -= weight * difference;
    }
};

SymmetricMatrix matrix_of(LevellingSystem& system) {
    const Eigen::Index num = system.right.rows();
    for (int i = 0; i < num; ++i) system.lower.emplace_back(i, i, kPull);
    Eigen::SparseMatrix<double, Eigen::RowMajor> lower(num, num);
    lower.setFromTriplets(system.lower.begin(), system.lower.end());
    system.lower = {};
    return lower.selfadjointView<Eigen::Lower>();
}

// Asks for the same additions at neighbouring vertices of a keyframe.
void add_smoothness(const types::Mesh& mesh,
                    const FaceViews& views,
                    const ColoredVertices& vertices,
                    LevellingSystem& system) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (views[i] == kNoView) continue;
        std::array<std::size_t, 3> corners;
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = vertices.number(mesh.triangles[i][k], views[i]);
        for (std::size_t k = 0; k < 3; ++k)
            if (corners[k] != corners[(k + 1) % 3])
                system.add(corners[k], corners[(k + 1) % 3], kSmoothness, Eigen::Vector3d::Zero());
    }
}

std::vector<Eigen::Vector3f> added_colors(const types::Mesh& mesh,
                                          const FaceViews& views,
                                          const SeamColors& colors,
                                          const Levelling& levelling,
                                          const base::ProgressShare& progress) {
    std::vector<Eigen::Vector3f> added(levelling.vertices.size(), Eigen::Vector3f::Zero());
    if (colors.seams.empty()) return added;
    LevellingSystem system(levelling.vertices.size());
    for (const Seam& seam : colors.seams)
        for (std::size_t end = 0; end < 2; ++end) {
            const SeamEnd at = seam_end(colors, seam, end, levelling);
            system.add(at.vertices[0], at.vertices[1], weight_of(at.step), at.step);
        }
    progress.at(0.1);
    add_smoothness(mesh, views, levelling.vertices, system);
    progress.at(0.2);
    const SymmetricMatrix matrix = matrix_of(system);
    base::ProgressShare rest = progress;
    rest.begin += 0.3 * (progress.end - progress.begin);
    const Eigen::MatrixX3d solution = solve_smooth_system(matrix, system.right, rest);
    for (std::size_t i = 0; i < added.size(); ++i)
        added[i] = solution.row(static_cast<Eigen::Index>(i)).transpose().cast<float>();
    return added;
}

}  // namespace

ColoredVertices::ColoredVertices(const types::Mesh& mesh, const FaceViews& views)
    : begin_(mesh.vertices.size() + 1, 0) {
    for (std::size_t i = 0; i < views.size(); ++i)
        if (views[i] != kNoView)
            for (const std::uint32_t vertex : mesh.triangles[i]) ++begin_[vertex + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    keyframes_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < views.size(); ++i)
        if (views[i] != kNoView)
            for (const std::uint32_t vertex : mesh.triangles[i])
                keyframes_[next[vertex]++] = views[i];
    std::uint32_t num_kept = 0;
    for (std::size_t vertex = 0; vertex < mesh.vertices.size(); ++vertex) {
        const auto begin = keyframes_.begin() + begin_[vertex];
        const auto end = keyframes_.begin() + next[vertex];
        std::sort(begin, end);
        begin_[vertex] = num_kept;
        const auto to = std::unique_copy(begin, end, keyframes_.begin() + num_kept);
        num_kept = static_cast<std::uint32_t>(to - keyframes_.begin());
    }
    begin_.back() = num_kept;
    keyframes_.resize(num_kept);
}

std::size_t ColoredVertices::number(std::uint32_t vertex, std::int32_t keyframe) const {
    const auto begin = keyframes_.begin() + begin_[vertex];
    const auto end = keyframes_.begin() + begin_[vertex + 1];
    return static_cast<std::size_t>(std::find(begin, end, keyframe) - keyframes_.begin());
}

Eigen::Vector3f Levelling::color(const SeamColors& colors,
                                 const Seam& seam,
                                 std::size_t side,
                                 std::uint32_t sample) const {
    const std::int32_t keyframe = seam.keyframes[side];
    const float along = seam.along(sample);
    return gains[keyframe].cwiseProduct(colors.color(seam, side, sample)) +
           (1.0F - along) * added_at(seam.edge.vertices[0], keyframe) +
           along * added_at(seam.edge.vertices[1], keyframe);
}

Levelling level_seams(const types::Mesh& mesh,
                      const FaceViews& views,
                      const SeamColors& colors,
                      std::size_t num_keyframes,
                      const base::ProgressShare& progress) {
    Levelling levelling = {level_gains(colors, num_keyframes), ColoredVertices(mesh, views), {}};
    progress.at(0.05);
    levelling.added = added_colors(mesh, views, colors, levelling, progress);
    return levelling;
}

}  // namespace divemesh::texture
