#include "worker/io/tile_texture.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "worker/base/disjoint_sets.hpp"
#include "worker/base/extend_pixels.hpp"
#include "worker/base/pixels_around.hpp"
#include "worker/io/half_size.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/types/triangle_area.hpp"

namespace divemesh::io {
namespace {

using Corners = std::array<Eigen::Vector2d, 3>;

// Returns where a triangle is in an atlas (centres of pixels at integers).
Corners corners_px(const std::array<Eigen::Vector2f, 3>& uv, const cv::Size& size) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k)
        corners[k] = {static_cast<double>(uv[k].x()) * size.width - 0.5,
                      static_cast<double>(uv[k].y()) * size.height - 0.5};
    return corners;
}

double area_px2(const Corners& corners) {
    const Eigen::Vector2d a = corners[1] - corners[0];
    const Eigen::Vector2d b = corners[2] - corners[0];
    return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
}

// Returns the pixels of the halved atlas that have a part of these, which are not negative.
cv::Rect halved(const cv::Rect& pixels, int num_halvings) {
    const cv::Point first(pixels.x >> num_halvings, pixels.y >> num_halvings);
    const cv::Point last((pixels.br().x - 1) >> num_halvings, (pixels.br().y - 1) >> num_halvings);
    return {first, last + cv::Point(1, 1)};
}

// Adds a border, less of it to what is nearly as large as an atlas.
cv::Rect with_border(const cv::Rect& pixels) {
    const auto border_px = [](int side_px) {
        return std::min(types::Texture::kBorder_px, (kMaxAtlas_px - side_px) / 2);
    };
    const cv::Point border(border_px(pixels.width), border_px(pixels.height));
    return {pixels.tl() - border, pixels.br() + border};
}

// Returns what halved pixels cover in the atlas.
cv::Rect doubled(const cv::Rect& pixels, int num_halvings) {
    const int factor = 1 << num_halvings;
    return {pixels.x * factor, pixels.y * factor, pixels.width * factor, pixels.height * factor};
}

}  // namespace

TileTexture::TileTexture(const types::Mesh& mesh,
                         const types::TextureMap& map,
                         AtlasImages& atlases)
    : mesh_(mesh), map_(map), atlases_(atlases) {
    base::DisjointSets joined(mesh.vertices.size());
    for (const auto& triangle : mesh.triangles) {
        joined.join(triangle[0], triangle[1]);
        joined.join(triangle[1], triangle[2]);
    }
    std::unordered_map<std::size_t, std::size_t> chart_of;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::int32_t atlas = map.atlas_of_triangle[i];
        if (atlas == types::TextureMap::kUntextured) continue;
        const auto [found, is_new] =
            chart_of.try_emplace(joined.find(mesh.triangles[i][0]), charts_.size());
        if (is_new) charts_.push_back({atlas, {}, {}});
        Chart& chart = charts_[found->second];
        const cv::Size& size = atlases.size(atlas);
        // The pixels of an empty rectangle and another are the other's.
        chart.pixels |= base::pixels_around(corners_px(map.uv[i], size)) & cv::Rect({}, size);
        chart.triangles.push_back(i);
    }
    // So that each atlas is decoded once.
    std::stable_sort(charts_.begin(), charts_.end(), [](const Chart& a, const Chart& b) {
        return a.atlas < b.atlas;
    });
}

// Returns what each chart fills in the halved atlas.
std::vector<cv::Rect> TileTexture::bordered(int num_halvings) const {
    std::vector<cv::Rect> pixels;
    for (const Chart& chart : charts_)
        pixels.push_back(with_border(halved(chart.pixels, num_halvings)));
    return pixels;
}

std::int64_t TileTexture::num_texels(int num_halvings) const {
    std::int64_t sum = 0;
    for (const cv::Rect& pixels : bordered(num_halvings)) sum += pixels.area();
    return sum;
}

double TileTexture::texel_m() const {
    double sum_m2 = 0.0;
    double sum_px2 = 0.0;
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
        const std::int32_t atlas = map_.atlas_of_triangle[i];
        if (atlas == types::TextureMap::kUntextured) continue;
        sum_m2 += types::triangle_area_m2(mesh_, mesh_.triangles[i]);
        sum_px2 += area_px2(corners_px(map_.uv[i], atlases_.size(atlas)));
    }
    return sum_px2 > 0.0 ? std::sqrt(sum_m2 / sum_px2) : 0.0;
}

types::Texture TileTexture::pack(int num_halvings) const {
    const std::vector<cv::Rect> pixels = bordered(num_halvings);
    std::vector<cv::Size> sizes;
    sizes.reserve(pixels.size());
    for (const cv::Rect& of_chart : pixels) sizes.push_back(of_chart.size());
    types::Texture packed;
    packed.atlas_of_triangle.assign(map_.uv.size(), types::Texture::kUntextured);
    packed.uv.resize(map_.uv.size());
    for (auto& corners : packed.uv) corners.fill(Eigen::Vector2f::Zero());
    fill(pixels, base::pack_rectangles(sizes, kMaxAtlas_px), num_halvings, packed);
    return packed;
}

// Fills the atlases and sets where the triangles are in them.
void TileTexture::fill(const std::vector<cv::Rect>& pixels,
                       const base::RectanglePacking& packing,
                       int num_halvings,
                       types::Texture& packed) const {
    for (const cv::Size& size : packing.sheets)
        packed.atlases.emplace_back(size, CV_8UC3, cv::Scalar::all(0.0));
    for (std::size_t i = 0; i < charts_.size(); ++i) {
        const Chart& chart = charts_[i];
        cv::Mat& atlas = packed.atlases[packing.sheet_of[i]];
        texels(chart, pixels[i], num_halvings)
            .copyTo(atlas(cv::Rect(packing.corners[i], pixels[i].size())));
        const cv::Point moved = packing.corners[i] - pixels[i].tl();
        for (const std::uint32_t triangle : chart.triangles) {
            packed.atlas_of_triangle[triangle] = packing.sheet_of[i];
            const Corners corners = corners_px(map_.uv[triangle], atlases_.size(chart.atlas));
            for (std::size_t k = 0; k < 3; ++k) {
                const double x = std::ldexp(corners[k].x() + 0.5, -num_halvings) + moved.x;
                const double y = std::ldexp(corners[k].y() + 0.5, -num_halvings) + moved.y;
                packed.uv[triangle][k] =
                    Eigen::Vector2d(x / atlas.cols, y / atlas.rows).cast<float>();
            }
        }
    }
}

// Returns the texels of a chart that fill a rectangle of the halved atlas, CV_8UC3.
cv::Mat TileTexture::texels(const Chart& chart, const cv::Rect& pixels, int num_halvings) const {
    const cv::Rect source = doubled(pixels, num_halvings);
    const cv::Mat atlas = atlases_.image(chart.atlas);
    const cv::Rect inside = source & cv::Rect({}, atlas.size());
    cv::Mat values(source.size(), CV_8UC4, cv::Scalar::all(0.0));
    cv::Mat known = values(inside - source.tl());
    cv::cvtColor(atlas(inside), known, cv::COLOR_BGR2BGRA);
    values.setTo(cv::Scalar::all(0.0), coverage(chart, source) == 0);
    for (int i = 0; i < num_halvings; ++i) values = half_size(values);
    cv::Mat alpha;
    cv::extractChannel(values, alpha, 3);
    base::extend_pixels<cv::Vec4b>(alpha == 0, values);
    cv::cvtColor(values, values, cv::COLOR_BGRA2BGR);
    return values;
}

// Returns which pixels of a rectangle of the atlas the triangles of a chart need, CV_8UC1.
cv::Mat TileTexture::coverage(const Chart& chart, const cv::Rect& source) const {
    constexpr int kShift = 4;     // the corners are rounded to 1/16 px
    constexpr int kReach_px = 2;  // what samples at an edge use; atlases have more around a chart
    cv::Mat covered(source.size(), CV_8UC1, cv::Scalar(0));
    for (const std::uint32_t i : chart.triangles) {
        const Corners corners = corners_px(map_.uv[i], atlases_.size(chart.atlas));
        std::array<cv::Point, 3> points;
        for (std::size_t k = 0; k < 3; ++k)
            points[k] = {cvRound(std::ldexp(corners[k].x() - source.x, kShift)),
                         cvRound(std::ldexp(corners[k].y() - source.y, kShift))};
        cv::fillConvexPoly(covered, points.data(), 3, cv::Scalar(255), cv::LINE_8, kShift);
    }
    const int side_px = 2 * kReach_px + 1;
    cv::dilate(covered, covered, cv::Mat::ones(side_px, side_px, CV_8UC1));
    return covered;
}

}  // namespace divemesh::io
