#include "worker/mosaic/mosaic_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/base/parallel.hpp"
#include "worker/mosaic/flat_triangle.hpp"
#include "worker/mosaic/surface_color.hpp"

namespace divemesh::mosaic {
namespace {

constexpr int kRowsOfGroup = 32;  // a group's depth buffer stays small
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

struct GroupRange {
    std::size_t first = 0;
    std::size_t last = 0;
};

GroupRange groups_of(const FlatTriangle& triangle, std::size_t num_groups) {
    const auto group_at = [&](double row_px) {
        const double group = std::floor(row_px / kRowsOfGroup);
        return static_cast<std::size_t>(
            std::clamp(group, 0.0, static_cast<double>(num_groups) - 1.0));
    };
    return {group_at(triangle.top_px() - 1.0), group_at(triangle.bottom_px() + 1.0)};
}

// The rows that one call draws: from `first_row` of the mosaic, to the same rows of `out` less
// `out_row`.
struct DrawnRows {
    int first_row = 0;
    int num_rows = 0;
    int out_row = 0;
};

// Draws the highest triangle of each pixel of some rows: first finds it, then colours it.
class RowsPainter {
public:
    RowsPainter(const types::Mesh& mesh,
                const types::Texture* texture,
                const types::RasterGrid& grid,
                const DrawnRows& drawn,
                MosaicRows& out)
        : mesh_(mesh),
          texture_(texture),
          grid_(grid),
          drawn_(drawn),
          out_(out),
          highest_(drawn.num_rows, grid.width_px, CV_32S, cv::Scalar(-1)) {}

    void add(std::uint32_t triangle) {
        const auto flat = FlatTriangle::of(mesh_, triangle, grid_);
        if (!flat) return;
        const int end_row = drawn_.first_row + drawn_.num_rows;
        const double top = std::max<double>(drawn_.first_row, std::floor(flat->top_px() - 1.0));
        const double bottom = std::min<double>(end_row - 1, std::ceil(flat->bottom_px()));
        for (int row = static_cast<int>(top); row <= static_cast<int>(bottom); ++row)
            add_row(triangle, *flat, row);
    }

    void paint() {
        for (int row = 0; row < drawn_.num_rows; ++row) {
            std::uint32_t known = kNoTriangle;
            std::optional<FlatTriangle> flat;
            for (int column = 0; column < grid_.width_px; ++column) {
                const auto triangle =
                    static_cast<std::uint32_t>(highest_.at<std::int32_t>(row, column));
                if (triangle == kNoTriangle) continue;
                if (triangle != known) flat = FlatTriangle::of(mesh_, triangle, grid_);
                known = triangle;
                paint_pixel(triangle, *flat, row, column);
            }
        }
    }

private:
    void add_row(std::uint32_t triangle, const FlatTriangle& flat, int row) {
        const ColumnSpan span = flat.span(row, grid_.width_px);
        const int from_first = row - drawn_.first_row;
        auto* heights = out_.height_m.ptr<float>(from_first + drawn_.out_row);
        auto* triangles = highest_.ptr<std::int32_t>(from_first);
        for (int column = span.first; column <= span.last; ++column) {
            const auto height_m = static_cast<float>(flat.height_m(flat.weights(row, column)));
            if (height_m <= heights[column]) continue;  // false where there is no surface yet
            heights[column] = height_m;
            triangles[column] = static_cast<std::int32_t>(triangle);
        }
    }

    void paint_pixel(std::uint32_t triangle, const FlatTriangle& flat, int row, int column) {
        const Eigen::Vector3d weights = flat.weights(drawn_.first_row + row, column);
        const Eigen::Vector3f color = surface_color(
            mesh_, texture_, triangle, {weights, flat.along_row(), flat.along_column()});
        auto& pixel = out_.color.at<cv::Vec4b>(row + drawn_.out_row, column);
        for (int channel = 0; channel < 3; ++channel)
            pixel[channel] = cv::saturate_cast<std::uint8_t>(color[channel]);
        pixel[3] = 255;
        if (mesh_.sigma_m.empty()) return;
        const auto& corners = mesh_.triangles[triangle];
        const Eigen::Vector3f sigmas(
            mesh_.sigma_m[corners[0]], mesh_.sigma_m[corners[1]], mesh_.sigma_m[corners[2]]);
        out_.sigma_m.at<float>(row + drawn_.out_row, column) = weights.cast<float>().dot(sigmas);
    }

    const types::Mesh& mesh_;
    const types::Texture* texture_;
    const types::RasterGrid& grid_;
    DrawnRows drawn_;
    MosaicRows& out_;
    cv::Mat highest_;  // CV_32S, the bits of the triangle's index; kNoTriangle where there is none
};

}  // namespace

MosaicRenderer::MosaicRenderer(const types::Mesh& mesh,
                               const types::Texture* texture,
                               const types::RasterGrid& grid,
                               int num_threads)
    : mesh_(mesh), texture_(texture), grid_(grid), num_threads_(num_threads) {
    sort_triangles();
}

void MosaicRenderer::sort_triangles() {
    const auto num_groups =
        static_cast<std::size_t>((grid_.height_px + kRowsOfGroup - 1) / kRowsOfGroup);
    const auto for_each_group = [&](const auto& visit) {
        for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
            const auto flat = FlatTriangle::of(mesh_, i, grid_);
            if (!flat) continue;
            const GroupRange groups = groups_of(*flat, num_groups);
            for (std::size_t group = groups.first; group <= groups.last; ++group)
                visit(group, static_cast<std::uint32_t>(i));
        }
    };
    begin_of_group_.assign(num_groups + 1, 0);
    for_each_group([&](std::size_t group, std::uint32_t) { ++begin_of_group_[group + 1]; });
    for (std::size_t i = 0; i < num_groups; ++i) begin_of_group_[i + 1] += begin_of_group_[i];
    triangles_of_groups_.resize(begin_of_group_.back());
    std::vector<std::size_t> next(begin_of_group_.begin(), begin_of_group_.end() - 1);
    for_each_group([&](std::size_t group, std::uint32_t triangle) {
        triangles_of_groups_[next[group]++] = triangle;
    });
}

MosaicRows MosaicRenderer::rows(int first_row, int num_rows) const {
    const cv::Size size(grid_.width_px, num_rows);
    MosaicRows out{cv::Mat(size, CV_8UC4, cv::Scalar::all(0)),
                   cv::Mat(size, CV_32F, cv::Scalar::all(kUnknown)),
                   cv::Mat(size, CV_32F, cv::Scalar::all(kUnknown))};
    const int first_group = first_row / kRowsOfGroup;
    const int end_group = (first_row + num_rows + kRowsOfGroup - 1) / kRowsOfGroup;
    base::for_each_index(
        num_threads_, static_cast<std::size_t>(end_group - first_group), [&](std::size_t index) {
            const std::size_t group = static_cast<std::size_t>(first_group) + index;
            if (begin_of_group_[group] == begin_of_group_[group + 1]) return;
            const int begin = std::max(first_row, static_cast<int>(group) * kRowsOfGroup);
            const int end =
                std::min(first_row + num_rows, (static_cast<int>(group) + 1) * kRowsOfGroup);
            RowsPainter painter(
                mesh_, texture_, grid_, {begin, end - begin, begin - first_row}, out);
            for (std::size_t i = begin_of_group_[group]; i < begin_of_group_[group + 1]; ++i)
                painter.add(triangles_of_groups_[i]);
            painter.paint();
        });
    return out;
}

}  // namespace divemesh::mosaic
