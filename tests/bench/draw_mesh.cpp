#include "tests/bench/draw_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "schemas/error.hpp"
#include "worker/mesh/image_camera.hpp"
#include "worker/mesh/triangle_pixels.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::bench {
namespace {

constexpr int kSamples = 2;  // along a row and a column of each pixel
const cv::Scalar kNoMesh(255, 0, 255);
const cv::Size kSize_px(1600, 1200);
constexpr double kFocal_px = 1600.0;
constexpr double kOutermost = 0.02;  // share of the vertices at either end of an axis
constexpr double kClose = 1.0 / 6.0;

std::vector<cv::Mat> decoded(const std::vector<std::string>& jpegs) {
    std::vector<cv::Mat> images;
    for (const std::string& jpeg : jpegs) {
        images.push_back(
            cv::imdecode(std::vector<char>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR));
        if (images.back().empty())
            throw Error(ErrorCode::BadData,
                        "atlas " + std::to_string(images.size() - 1) + " cannot be decoded");
    }
    return images;
}

// Returns the colour between four texels, whose centres are at halves.
cv::Vec3f bilinear(const cv::Mat& image, const Eigen::Vector2f& uv) {
    const float x = uv.x() * static_cast<float>(image.cols) - 0.5F;
    const float y = uv.y() * static_cast<float>(image.rows) - 0.5F;
    const auto left = static_cast<int>(std::floor(x));
    const auto top = static_cast<int>(std::floor(y));
    cv::Vec3f color(0.0F, 0.0F, 0.0F);
    for (const int row : {top, top + 1})
        for (const int column : {left, left + 1}) {
            const float weight = (1.0F - std::abs(x - static_cast<float>(column))) *
                                 (1.0F - std::abs(y - static_cast<float>(row)));
            const auto& texel = image.at<cv::Vec3b>(std::clamp(row, 0, image.rows - 1),
                                                    std::clamp(column, 0, image.cols - 1));
            color += weight * cv::Vec3f(texel);
        }
    return color;
}

class Drawing {
public:
    Drawing(const io::TexturedMesh& shown, const mesh::ImageCamera& camera)
        : shown_(shown),
          camera_(camera),
          atlases_(decoded(shown.texture.jpegs)),
          image_(camera.rows, camera.columns, CV_8UC3, kNoMesh),
          inverse_depth_(camera.rows, camera.columns, CV_32F, cv::Scalar(0.0)) {}

    void add_triangle(std::size_t triangle) {
        mesh::PixelTriangle corners;
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = camera_.project(shown_.mesh.vertices[shown_.mesh.triangles[triangle][k]]);
        const auto is_behind = [](const Eigen::Vector3f& corner) { return corner.z() <= 0.0F; };
        if (std::any_of(corners.begin(), corners.end(), is_behind)) return;
        mesh::for_each_pixel(
            corners,
            image_.rows,
            image_.cols,
            [&](int row, int column, const Eigen::Vector3f& weights, float inverse_depth) {
                auto& nearest = inverse_depth_.at<float>(row, column);
                if (inverse_depth <= nearest) return;
                nearest = inverse_depth;
                // Weights on the triangle itself, not on its image.
                const Eigen::Vector3f on_surface =
                    weights.cwiseProduct(
                        Eigen::Vector3f(corners[0].z(), corners[1].z(), corners[2].z())) /
                    inverse_depth;
                image_.at<cv::Vec3b>(row, column) = color(triangle, on_surface);
            });
    }
    const cv::Mat& image() const { return image_; }

private:
    cv::Vec3b color(std::size_t triangle, const Eigen::Vector3f& weights) const {
        const std::int32_t atlas = shown_.texture.atlas_of_triangle[triangle];
        if (atlas != types::TextureMap::kUntextured) {
            const auto& corners = shown_.texture.uv[triangle];
            const Eigen::Vector2f uv =
                weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
            return bilinear(atlases_[static_cast<std::size_t>(atlas)], uv);
        }
        cv::Vec3f bgr(0.0F, 0.0F, 0.0F);
        if (shown_.mesh.colors.empty()) return bgr;
        for (std::size_t k = 0; k < 3; ++k) {
            const types::Color& rgb = shown_.mesh.colors[shown_.mesh.triangles[triangle][k]];
            bgr += weights[static_cast<Eigen::Index>(k)] * cv::Vec3f(rgb[2], rgb[1], rgb[0]);
        }
        return bgr;
    }

    const io::TexturedMesh& shown_;
    const mesh::ImageCamera& camera_;
    std::vector<cv::Mat> atlases_;
    cv::Mat image_;
    cv::Mat inverse_depth_;
};

Eigen::AlignedBox3d box_of(const types::Mesh& mesh) {
    Eigen::AlignedBox3d box;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        for (const Eigen::Vector3f& vertex : mesh.vertices) values.push_back(vertex[axis]);
        std::sort(values.begin(), values.end());
        box.min()[axis] = stats::quantile_of_sorted(values, kOutermost);
        box.max()[axis] = stats::quantile_of_sorted(values, 1.0 - kOutermost);
    }
    return box;
}

// Returns the axes of a camera that looks against a direction, with z up in its image if it can.
Eigen::Matrix3d looking_against(const Eigen::Vector3d& direction) {
    const Eigen::Vector3d up =
        std::abs(direction.z()) > 0.99 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
    Eigen::Matrix3d R;
    R.col(2) = -direction;
    R.col(0) = R.col(2).cross(up).normalized();
    R.col(1) = R.col(2).cross(R.col(0));
    return R;
}

// Returns the distance from the middle of a box at which the image just holds it.
double distance_m(const Eigen::AlignedBox3d& box, const Eigen::Matrix3d& R_world_cam) {
    double farthest_m = 0.0;
    for (int i = 0; i < 8; ++i) {
        const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(i);
        const Eigen::Vector3d p = R_world_cam.transpose() * (box.corner(corner) - box.center());
        farthest_m = std::max({farthest_m,
                               2.0 * kFocal_px * std::abs(p.x()) / kSize_px.width - p.z(),
                               2.0 * kFocal_px * std::abs(p.y()) / kSize_px.height - p.z()});
    }
    return farthest_m;
}

Viewpoint viewpoint(const Eigen::Vector3d& target,
                    const Eigen::Matrix3d& R_world_cam,
                    double target_distance_m) {
    Viewpoint from{Eigen::Isometry3d::Identity(), kFocal_px, kSize_px};
    from.T_world_cam.linear() = R_world_cam;
    from.T_world_cam.translation() = target - target_distance_m * R_world_cam.col(2);
    return from;
}

}  // namespace

cv::Mat draw_mesh(const io::TexturedMesh& shown, const Viewpoint& viewpoint) {
    types::RectifiedRig rig;
    rig.width_px = viewpoint.size_px.width;
    rig.height_px = viewpoint.size_px.height;
    rig.focal_px = viewpoint.focal_px;
    const Eigen::Vector2d middle(0.5 * rig.width_px - 0.5, 0.5 * rig.height_px - 0.5);
    rig.cx_px = viewpoint.center_px.value_or(middle).x();
    rig.cy_px = viewpoint.center_px.value_or(middle).y();
    const mesh::ImageCamera camera(
        rig, viewpoint.T_world_cam, kSamples * rig.width_px, kSamples * rig.height_px);
    Drawing drawing(shown, camera);
    for (std::size_t i = 0; i < shown.mesh.triangles.size(); ++i) drawing.add_triangle(i);
    cv::Mat image;
    cv::resize(drawing.image(), image, viewpoint.size_px, 0.0, 0.0, cv::INTER_AREA);
    return image;
}

Viewpoint whole_view(const types::Mesh& mesh, const Eigen::Vector3d& direction) {
    const Eigen::AlignedBox3d box = box_of(mesh);
    const Eigen::Matrix3d R = looking_against(direction);
    return viewpoint(box.center(), R, distance_m(box, R));
}

Viewpoint close_view(const types::Mesh& mesh, const Eigen::Vector3d& direction) {
    const Eigen::AlignedBox3d box = box_of(mesh);
    const Eigen::Matrix3d R = looking_against(direction);
    const auto is_nearer = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
        return (a.cast<double>() - box.center()).norm() < (b.cast<double>() - box.center()).norm();
    };
    const Eigen::Vector3d target =
        std::min_element(mesh.vertices.begin(), mesh.vertices.end(), is_nearer)->cast<double>();
    return viewpoint(target, R, kClose * distance_m(box, R));
}

}  // namespace divemesh::bench
