#include "worker/mosaic/mosaic.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/mesh/mean_edge.hpp"
#include "worker/mesh/triangle_pixels.hpp"

namespace divemesh::mosaic {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

struct Bounds {
    Eigen::Vector2f low = Eigen::Vector2f::Constant(std::numeric_limits<float>::max());
    Eigen::Vector2f high = Eigen::Vector2f::Constant(std::numeric_limits<float>::lowest());

    Eigen::Vector2f size() const { return high - low; }
};

Bounds bounds_of(const types::Mesh& mesh) {
    Bounds bounds;
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t vertex : triangle) {
            bounds.low = bounds.low.cwiseMin(mesh.vertices[vertex].head<2>());
            bounds.high = bounds.high.cwiseMax(mesh.vertices[vertex].head<2>());
        }
    return bounds;
}

double choose_pixel_m(const types::Mesh& mesh, const Bounds& bounds, const MosaicOptions& options) {
    constexpr double kMinPixel_m = 1e-4;
    const Eigen::Vector2d size = bounds.size().cast<double>();
    double pixel_m = options.pixel_m > 0.0 ? options.pixel_m : 0.5 * mesh::mean_edge_m(mesh);
    pixel_m = std::max({pixel_m,
                        kMinPixel_m,
                        size.maxCoeff() / (options.max_side_px - 1),
                        std::sqrt(size.prod() / static_cast<double>(options.max_pixels))});
    return pixel_m;
}

struct ScreenTriangle {
    mesh::PixelTriangle corners;
    std::array<Eigen::Vector3f, 3> colors;  // b g r
};

Eigen::Vector3f color_of(const types::Mesh& mesh, std::uint32_t vertex) {
    if (!mesh.colors.empty()) {
        const types::Color& color = mesh.colors[vertex];
        return {static_cast<float>(color[2]),
                static_cast<float>(color[1]),
                static_cast<float>(color[0])};
    }
    const float light = mesh.normals.empty() ? 0.7F : std::abs(mesh.normals[vertex].z());
    return Eigen::Vector3f::Constant(60.0F + 180.0F * light);
}

// Draws a triangle with a z-buffer; the higher surface is visible.
void draw(const ScreenTriangle& triangle, Mosaic& mosaic) {
    const auto paint = [&](int row, int column, const Eigen::Vector3f& weights, float height) {
        auto& highest = mosaic.height_m.at<float>(row, column);
        if (height <= highest) return;  // false where there was no surface
        highest = height;
        const Eigen::Vector3f color = weights[0] * triangle.colors[0] +
                                      weights[1] * triangle.colors[1] +
                                      weights[2] * triangle.colors[2];
        auto& pixel = mosaic.color.at<cv::Vec4b>(row, column);
        for (int channel = 0; channel < 3; ++channel)
            pixel[channel] = cv::saturate_cast<std::uint8_t>(color[channel]);
        pixel[3] = 255;
    };
    mesh::for_each_pixel(triangle.corners, mosaic.color.rows, mosaic.color.cols, paint);
}

}  // namespace

Mosaic render_mosaic(const types::Mesh& mesh, const MosaicOptions& options) {
    Mosaic mosaic;
    int width_px = 1;
    int height_px = 1;
    mosaic.pixel_m = 1.0;
    if (!mesh.triangles.empty()) {
        const Bounds bounds = bounds_of(mesh);
        mosaic.pixel_m = choose_pixel_m(mesh, bounds, options);
        mosaic.corner_x_m = static_cast<double>(bounds.low.x());
        mosaic.corner_y_m = static_cast<double>(bounds.high.y());
        width_px = 1 + static_cast<int>(static_cast<double>(bounds.size().x()) / mosaic.pixel_m);
        height_px = 1 + static_cast<int>(static_cast<double>(bounds.size().y()) / mosaic.pixel_m);
    }
    mosaic.color = cv::Mat(height_px, width_px, CV_8UC4, cv::Scalar::all(0));
    mosaic.height_m = cv::Mat(height_px, width_px, CV_32F, cv::Scalar::all(kNothing));
    for (const auto& triangle : mesh.triangles) {
        ScreenTriangle screen;
        for (std::size_t i = 0; i < 3; ++i) {
            const Eigen::Vector3d vertex = mesh.vertices[triangle[i]].cast<double>();
            screen.corners[i] = Eigen::Vector3d((vertex.x() - mosaic.corner_x_m) / mosaic.pixel_m,
                                                (mosaic.corner_y_m - vertex.y()) / mosaic.pixel_m,
                                                vertex.z())
                                    .cast<float>();
            screen.colors[i] = color_of(mesh, triangle[i]);
        }
        draw(screen, mosaic);
    }
    return mosaic;
}

std::string thumbnail_png(const Mosaic& mosaic, int max_side_px) {
    cv::Mat image(mosaic.color.size(), CV_8UC3);
    for (int row = 0; row < image.rows; ++row)
        for (int column = 0; column < image.cols; ++column) {
            const auto& pixel = mosaic.color.at<cv::Vec4b>(row, column);
            image.at<cv::Vec3b>(row, column) =
                pixel[3] == 0 ? cv::Vec3b(255, 255, 255) : cv::Vec3b(pixel[0], pixel[1], pixel[2]);
        }
    const double scale = static_cast<double>(max_side_px) / std::max(image.rows, image.cols);
    if (scale < 1.0) cv::resize(image, image, {}, scale, scale, cv::INTER_AREA);
    std::vector<std::uint8_t> png;
    cv::imencode(".png", image, png);
    return {png.begin(), png.end()};
}

}  // namespace divemesh::mosaic
