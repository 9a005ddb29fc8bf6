#include "worker/compare/change_images.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/base/atomic_file.hpp"
#include "worker/compare/changed_mesh.hpp"
#include "worker/compare/outlined_cells.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::compare {
namespace {

constexpr double kMinFull_m = 0.02;
constexpr double kHeightStep_m = 1e-4;
constexpr int kZeroHeight = 32768;

cv::Vec3b bgr(const types::Color& color) { return {color[2], color[1], color[0]}; }

std::vector<Eigen::Vector3f> shades(const types::Mesh& mesh) {
    std::vector<Eigen::Vector3f> colors(mesh.vertices.size());
    for (std::size_t i = 0; i < colors.size(); ++i)
        colors[i] = mesh.colors.empty()
                        ? Eigen::Vector3f::Constant(60.0F + 180.0F * std::abs(mesh.normals[i].z()))
                        : Eigen::Vector3f(static_cast<float>(mesh.colors[i][2]),
                                          static_cast<float>(mesh.colors[i][1]),
                                          static_cast<float>(mesh.colors[i][0]));
    return colors;
}

cv::Vec3b faint(const cv::Vec3b& color, double strength) {
    const double grey = (0.114 * color[0] + 0.587 * color[1] + 0.299 * color[2]);
    const auto value = static_cast<std::uint8_t>(255.0 - strength * (255.0 - grey));
    return {value, value, value};
}

cv::Vec3b cell_color(const ChangeMap& map, int row, int column, const cv::Vec3b& b, double full_m) {
    const CellState state = map.at(row, column);
    switch (state) {
        case CellState::Unseen: return {255, 255, 255};
        case CellState::OnlyA: return {235, 235, 225};
        case CellState::OnlyB: return faint(b, 0.25);
        case CellState::Stable: return faint(b, 0.6);
        case CellState::Hidden:
            return (row + column) % 8 < 3 ? cv::Vec3b(60, 140, 200) : faint(b, 0.6);
        case CellState::Grown:
        case CellState::Lost: break;
    }
    return bgr(change_color(static_cast<double>(map.change_m.at<float>(row, column)), full_m));
}

// Returns the image region of each patch, by number - 1.
std::vector<cv::Rect> windows_of(const Changes& changes) {
    std::vector<cv::Rect> windows(changes.patches.size());
    for (int row = 0; row < changes.number.rows; ++row)
        for (int column = 0; column < changes.number.cols; ++column)
            if (const int number = changes.number.at<int>(row, column); number > 0)
                windows[static_cast<std::size_t>(number - 1)] |= cv::Rect(column, row, 1, 1);
    return windows;
}

int line_px(const cv::Mat& image) {
    const double longest = std::max(image.rows, image.cols);
    return std::max(1, static_cast<int>(std::lround(longest / kDisplaySide_px)));
}

void write_mark(cv::Mat& image,
                const std::string& mark,
                const Eigen::Vector2d& corner,
                double size,
                const cv::Scalar& color) {
    const int width = line_px(image);
    cv::putText(
        image,
        mark,
        {static_cast<int>(corner.x()) + 4 * width, static_cast<int>(corner.y()) + 4 * width},
        cv::FONT_HERSHEY_SIMPLEX,
        size * width,
        color,
        width,
        cv::LINE_AA);
}

void draw_outlines(cv::Mat& image,
                   const std::vector<ComparedOutline>& outlines,
                   const RasterGrid& grid) {
    constexpr int kShift = 4;  // fractional bits of a pixel
    const int width = line_px(image);
    for (const ComparedOutline& one : outlines) {
        const bool is_earlier = one.mark.starts_with('A');
        const cv::Scalar color = is_earlier ? cv::Scalar(40, 120, 0) : cv::Scalar(150, 30, 130);
        std::vector<cv::Point> corners;
        Eigen::AlignedBox2d box;
        for (const Eigen::Vector2d& p : in_cells(one.outline, grid)) {
            const Eigen::Vector2d pixel = p.array() - 0.5;
            box.extend(pixel);
            corners.emplace_back(static_cast<int>(std::lround(std::ldexp(pixel.x(), kShift))),
                                 static_cast<int>(std::lround(std::ldexp(pixel.y(), kShift))));
        }
        cv::polylines(image, corners, true, color, width, cv::LINE_AA, kShift);
        // Marks of one colony side by side.
        write_mark(image,
                   one.mark,
                   {is_earlier ? box.min().x() - 8.0 * width : box.center().x(),
                    std::min(box.max().y() + 8.0 * width, image.rows - 8.0 * width)},
                   0.4,
                   color);
    }
}

void outline_patches(cv::Mat& image, const Changes& changes, const RasterGrid& grid) {
    const std::vector<cv::Rect> windows = windows_of(changes);
    for (const ChangePatch& patch : changes.patches) {
        const cv::Rect& window = windows[static_cast<std::size_t>(patch.number - 1)];
        std::vector<std::vector<cv::Point>> lines;
        if (!window.empty())
            cv::findContours(changes.number(window) == patch.number,
                             lines,
                             cv::RETR_EXTERNAL,
                             cv::CHAIN_APPROX_NONE,
                             window.tl());
        const cv::Scalar color = patch.grown ? cv::Scalar(120, 50, 0) : cv::Scalar(20, 0, 110);
        cv::drawContours(image, lines, -1, color, line_px(image));
        const Eigen::Vector2d at = (patch.box_m.max() - grid.corner_m) / grid.cell_m;
        write_mark(image, std::to_string(patch.number), {at.x(), -at.y()}, 0.55, color);
    }
}

}  // namespace

double full_change_m(const ChangeMap& map) {
    std::vector<float> sizes;
    for (int row = 0; row < map.state.rows; ++row)
        for (int column = 0; column < map.state.cols; ++column)
            if (map.at(row, column) == CellState::Grown || map.at(row, column) == CellState::Lost)
                sizes.push_back(std::abs(map.change_m.at<float>(row, column)));
    return std::max(kMinFull_m, static_cast<double>(stats::lower_quantile(std::move(sizes), 0.95)));
}

cv::Mat draw_surface(const types::Mesh& mesh, const RasterGrid& grid) {
    const SurfaceRaster raster = rasterise(mesh, grid);
    const auto colors = shades(mesh);
    cv::Mat image(grid.rows, grid.columns, CV_8UC3, cv::Scalar::all(255));
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column) {
            if (!raster.seen(row, column)) continue;
            const Eigen::Vector3f color = raster.interpolate(mesh, colors, row, column);
            for (int channel = 0; channel < 3; ++channel)
                image.at<cv::Vec3b>(row, column)[channel] =
                    cv::saturate_cast<std::uint8_t>(color[channel]);
        }
    return image;
}

cv::Mat draw_changes(const types::Mesh& b,
                     const ChangeMap& map,
                     const Changes& changes,
                     const std::vector<ComparedOutline>& outlines,
                     double full_m) {
    const cv::Mat under = draw_surface(b, map.grid);
    cv::Mat image(under.size(), CV_8UC3);
    for (int row = 0; row < image.rows; ++row)
        for (int column = 0; column < image.cols; ++column)
            image.at<cv::Vec3b>(row, column) =
                cell_color(map, row, column, under.at<cv::Vec3b>(row, column), full_m);
    draw_outlines(image, outlines, map.grid);
    outline_patches(image, changes, map.grid);
    return image;
}

std::string encode_png(const cv::Mat& image) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".png", image, bytes);
    return {bytes.begin(), bytes.end()};
}

std::string encode_jpeg(const cv::Mat& image, int max_side_px) {
    cv::Mat small = image;
    const double scale = static_cast<double>(max_side_px) / std::max(image.rows, image.cols);
    if (scale < 1.0) cv::resize(image, small, {}, scale, scale, cv::INTER_AREA);
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, 88});
    return {bytes.begin(), bytes.end()};
}

void write_difference(const std::filesystem::path& folder,
                      const cv::Mat& image,
                      const ChangeMap& map,
                      bool has_outlines,
                      double full_m) {
    cv::Mat heights(map.state.size(), CV_16U, cv::Scalar::all(0));
    for (int row = 0; row < heights.rows; ++row)
        for (int column = 0; column < heights.cols; ++column) {
            const auto change = static_cast<double>(map.change_m.at<float>(row, column));
            if (std::isnan(change) || map.at(row, column) == CellState::Hidden) continue;
            heights.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(
                std::clamp(kZeroHeight + std::round(change / kHeightStep_m), 1.0, 65535.0));
        }
    nlohmann::json description = {
        {"frame", "world of the earlier dive (m, z up); columns run along +x, rows along -y"},
        {"width_px", image.cols},
        {"height_px", image.rows},
        {"pixel_m", map.grid.cell_m},
        {"corner_x_m", map.grid.corner_m.x()},
        {"corner_y_m", map.grid.corner_m.y()},
        {"color_file", "mosaic_difference.png"},
        {"colors",
         {{"grown", "white to blue, blue at full_change_m and more"},
          {"lost", "white to red, red at -full_change_m and less"},
          {"stable", "the later dive in grey"},
          {"hidden", "orange lines: one dive did not look where the other has its surface"},
          {"one dive alone", "pale"},
          {"full_change_m", full_m}}},
        {"change",
         {{"file", "change_height.png"},
          {"meaning",
           "height of the later surface over the earlier one, m = (value - 32768) * step_m; value "
           "0: not compared"},
          {"step_m", kHeightStep_m}}}};
    if (has_outlines)
        description["colors"]["outlines"] =
            "green: of the earlier dive, A1, A2 ...; violet: of the later, B1 ...";
    base::write_file(folder / "mosaic_difference.png", encode_png(image));
    base::write_file(folder / "change_height.png", encode_png(heights));
    base::write_file(folder / "mosaic_difference.json", description.dump(2) + "\n");
}

}  // namespace divemesh::compare
