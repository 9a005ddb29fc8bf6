#include "worker/texture/texture_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>

#include "schemas/error.hpp"
#include "tests/synthetic/ideal_rig.hpp"
#include "worker/base/bilinear.hpp"
#include "worker/mesh/triangle_pixels.hpp"
#include "worker/texture/shared_edges.hpp"

namespace divemesh::texture {
namespace {

// Returns the colour of the plane z = 0, b g r.
Eigen::Vector3d plane_color(double x_m, double y_m) {
    const double wave = 30.0 * std::sin(31.0 * x_m + 5.0 * y_m) +
                        25.0 * std::sin(23.0 * y_m - 12.0 * x_m + 1.0) +
                        20.0 * std::sin(17.0 * x_m + 29.0 * y_m + 2.0);
    return {110.0 + 0.7 * wave, 100.0 - 0.6 * wave, 90.0 + 0.4 * wave};
}

// What a camera makes of a colour at a pixel.
using Response = std::function<Eigen::Vector3d(
    std::size_t keyframe, const Eigen::Vector2d& pixel, const Eigen::Vector3d& color)>;

// A textured plane, 3 m x 1.2 m, below four cameras at 2 m that each see a part of it.
struct PlaneScene {
    types::RectifiedRig rig = synthetic::ideal_rig(320, 240, 300.0);
    std::vector<types::Keyframe> keyframes;
    std::vector<cv::Mat> images;  // empty: cannot be read
    types::Mesh mesh;
    FaceViews views;

    keyframes::ReadImage read_image() const {
        return [this](int frame_index) {
            const cv::Mat& image = images[frame_index / 10];
            if (image.empty()) throw Error(ErrorCode::NotFound, "no image");
            return image;
        };
    }
    types::Texture texture(const AtlasOptions& options = {}, int num_threads = 2) const {
        const keyframes::ReadImage read = read_image();
        const Photographs photographs(rig, keyframes, read);
        return texture_mesh(mesh, views, photographs, options, num_threads, base::ignore_progress);
    }
    Eigen::Vector3d center(std::size_t triangle) const {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const std::uint32_t vertex : mesh.triangles[triangle])
            sum += mesh.vertices[vertex].cast<double>() / 3.0;
        return sum;
    }
};

void add_camera(PlaneScene& scene, double x_m, double tilt_rad, const Response& response) {
    const auto index = scene.keyframes.size();
    types::Keyframe keyframe;
    keyframe.frame_index = static_cast<int>(10 * index);
    keyframe.T_world_cam.translation() = Eigen::Vector3d(x_m, 0.6, 2.0);
    keyframe.T_world_cam.linear() =
        Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX()).toRotationMatrix() *
        Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
    scene.keyframes.push_back(keyframe);
    cv::Mat image(scene.rig.height_px, scene.rig.width_px, CV_8UC3);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const Eigen::Vector3d ray =
                keyframe.T_world_cam.linear() * scene.rig.point_cam(u, v, 1.0);
            const Eigen::Vector3d hit = keyframe.T_world_cam.translation() + ray * (-2.0 / ray.z());
            const Eigen::Vector3d color =
                response(index, Eigen::Vector2d(u, v), plane_color(hit.x(), hit.y()));
            for (int channel = 0; channel < 3; ++channel)
                image.at<cv::Vec3b>(v, u)[channel] =
                    cv::saturate_cast<std::uint8_t>(color[channel]);
        }
    scene.images.push_back(image);
}

PlaneScene plane_scene(const Response& response) {
    PlaneScene scene;
    const double tilts_rad[] = {0.05, -0.08, 0.0, 0.06};
    for (int i = 0; i < 4; ++i) add_camera(scene, 0.4 + 0.7 * i, tilts_rad[i], response);
    constexpr int kColumns = 60;
    constexpr int kRows = 24;
    constexpr float kStep_m = 0.05F;
    for (int row = 0; row <= kRows; ++row)
        for (int column = 0; column <= kColumns; ++column)
            scene.mesh.vertices.emplace_back(
                kStep_m * static_cast<float>(column), kStep_m * static_cast<float>(row), 0.0F);
    for (std::uint32_t row = 0; row < kRows; ++row)
        for (std::uint32_t column = 0; column < kColumns; ++column) {
            const std::uint32_t a = row * (kColumns + 1) + column;
            const std::uint32_t b = a + kColumns + 1;
            scene.mesh.triangles.push_back({a, a + 1, b + 1});
            scene.mesh.triangles.push_back({a, b + 1, b});
        }
    for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
        const Eigen::Vector3d center = scene.center(i);
        const double along_m = center.x() + 0.1 * std::sin(9.0 * center.y());
        scene.views.push_back(std::clamp(static_cast<int>(along_m / 0.7), 0, 3));
    }
    return scene;
}

Eigen::Vector3d unchanged(std::size_t, const Eigen::Vector2d&, const Eigen::Vector3d& color) {
    return color;
}

Eigen::Vector3d with_gains(std::size_t keyframe,
                           const Eigen::Vector2d&,
                           const Eigen::Vector3d& color) {
    const Eigen::Vector3d gains[] = {
        {1.0, 1.0, 1.0}, {0.75, 0.8, 0.85}, {1.2, 1.25, 1.15}, {0.9, 0.7, 1.1}};
    return color.cwiseProduct(gains[keyframe]);
}

// Water that scatters light back from one side more than from the other.
Eigen::Vector3d with_backscatter(std::size_t keyframe,
                                 const Eigen::Vector2d& pixel,
                                 const Eigen::Vector3d& color) {
    const double slope = keyframe % 2 == 0 ? 24.0 : -12.0;
    const double added = 10.0 + slope * (pixel.x() / 320.0 - 0.5) + 8.0 * pixel.y() / 240.0;
    return color + added * Eigen::Vector3d(1.0, 0.8, 0.3);
}

// Returns the colour of a triangle at barycentric weights.
Eigen::Vector3d look_up(const types::Texture& texture,
                        std::size_t triangle,
                        const Eigen::Vector3f& weights) {
    const cv::Mat& atlas = texture.atlases[texture.atlas_of_triangle[triangle]];
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();
    for (std::size_t k = 0; k < 3; ++k) uv += weights[k] * texture.uv[triangle][k];
    const Eigen::Vector2f place(uv.x() * static_cast<float>(atlas.cols) - 0.5F,
                                uv.y() * static_cast<float>(atlas.rows) - 0.5F);
    return base::bilinear_color(atlas, place).cast<double>();
}

Eigen::Vector3d look_up_center(const types::Texture& texture, std::size_t triangle) {
    return look_up(texture, triangle, Eigen::Vector3f::Constant(1.0F / 3.0F));
}

Eigen::Vector3f weights_on_edge(const types::Mesh& mesh,
                                std::size_t triangle,
                                const SharedEdge& edge,
                                float along) {
    Eigen::Vector3f weights = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
        if (mesh.triangles[triangle][k] == edge.vertices[0]) weights[k] = 1.0F - along;
        if (mesh.triangles[triangle][k] == edge.vertices[1]) weights[k] = along;
    }
    return weights;
}

// Returns the mean absolute step of the colours across the seams.
double mean_step(const PlaneScene& scene, const types::Texture& texture) {
    double sum = 0.0;
    int num = 0;
    for (const SharedEdge& edge : shared_edges(scene.mesh)) {
        const auto [a, b] = edge.triangles;
        if (scene.views[a] == scene.views[b]) continue;
        for (const float along : {0.1F, 0.3F, 0.5F, 0.7F, 0.9F}) {
            const Eigen::Vector3d step =
                look_up(texture, a, weights_on_edge(scene.mesh, a, edge, along)) -
                look_up(texture, b, weights_on_edge(scene.mesh, b, edge, along));
            sum += step.cwiseAbs().mean();
            ++num;
        }
    }
    EXPECT_GT(num, 100);
    return sum / num;
}

TEST(TextureMesh, GainsOfTheCamerasVanishUpToOneInCommon) {
    const PlaneScene scene = plane_scene(with_gains);
    const types::Texture texture = scene.texture();
    EXPECT_LE(mean_step(scene, texture), 1.0);
    Eigen::Vector3d products = Eigen::Vector3d::Zero();
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
        const Eigen::Vector3d at = scene.center(i);
        const Eigen::Vector3d truth = plane_color(at.x(), at.y());
        products += truth.cwiseProduct(look_up_center(texture, i));
        squares += truth.cwiseProduct(truth);
    }
    const Eigen::Vector3d gain = products.cwiseQuotient(squares);
    for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
        const Eigen::Vector3d at = scene.center(i);
        const Eigen::Vector3d truth = gain.cwiseProduct(plane_color(at.x(), at.y()));
        ASSERT_LE((look_up_center(texture, i) - truth).cwiseAbs().maxCoeff(), 2.0)
            << at.transpose();
    }
    EXPECT_NEAR(gain[0], std::pow(1.0 * 0.75 * 1.2 * 0.9, 0.25), 0.01);  // their geometric mean
}

TEST(TextureMesh, StepsOfBackscatterVanishAndTheMeanStays) {
    const PlaneScene scene = plane_scene(with_backscatter);
    const types::Texture texture = scene.texture();
    EXPECT_LE(mean_step(scene, texture), 1.0);
    const keyframes::ReadImage read = scene.read_image();
    const Photographs photographs(scene.rig, scene.keyframes, read);
    Eigen::Vector3d drift = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) {
        const Eigen::Vector2d pixel =
            photographs.pixel(scene.views[i], scene.center(i).cast<float>()).value();
        drift +=
            look_up_center(texture, i) -
            base::bilinear_color(scene.images[scene.views[i]], pixel.cast<float>()).cast<double>();
    }
    drift /= static_cast<double>(scene.mesh.triangles.size());
    EXPECT_LE(drift.cwiseAbs().maxCoeff(), 1.0);
}

TEST(TextureMesh, AStripThatShowsSomethingElseSpoilsNoNeighbour) {
    PlaneScene scene = plane_scene(unchanged);
    scene.images[1](cv::Rect(0, 90, 320, 40)).setTo(cv::Scalar(255, 255, 255));
    const types::Texture texture = scene.texture();
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
        if (scene.views[i] == 1) continue;
        const Eigen::Vector3d at = scene.center(i);
        ASSERT_LE((look_up_center(texture, i) - plane_color(at.x(), at.y())).cwiseAbs().maxCoeff(),
                  4.0)
            << at.transpose();
    }
}

TEST(TextureMesh, WithoutSeamsTheAtlasIsTheImageBeyondTheChartToo) {
    PlaneScene scene = plane_scene(unchanged);
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
        const Eigen::Vector3d from_camera = scene.center(i) - Eigen::Vector3d(1.8, 0.6, 0.0);
        scene.views[i] = from_camera.head<2>().norm() < 0.3 ? 2 : kNoView;
    }
    const types::Texture texture = scene.texture();
    ASSERT_EQ(texture.atlases.size(), 1U);
    const auto chart =
        std::find(texture.atlas_of_triangle.begin(), texture.atlas_of_triangle.end(), 0) -
        texture.atlas_of_triangle.begin();
    const Eigen::Vector3d p_cam =
        scene.keyframes[2].T_world_cam.inverse() *
        scene.mesh.vertices[scene.mesh.triangles[chart][0]].cast<double>();
    const Eigen::Vector2d pixel = scene.rig.pixel(p_cam);
    const cv::Mat& atlas = texture.atlases[0];
    const Eigen::Vector2d shift =
        pixel -
        (texture.uv[chart][0].cast<double>().cwiseProduct(Eigen::Vector2d(atlas.cols, atlas.rows)) -
         Eigen::Vector2d::Constant(0.5));
    const cv::Rect cutout(static_cast<int>(std::lround(shift.x())),
                          static_cast<int>(std::lround(shift.y())),
                          atlas.cols,
                          atlas.rows);
    EXPECT_NEAR(cutout.width, 0.6 * 150.0 + 2 * types::Texture::kBorder_px, 12);
    EXPECT_EQ(cv::norm(atlas, scene.images[2](cutout), cv::NORM_INF), 0.0);
}

TEST(TextureMesh, ATexelIsAPixelAndChartsDoNotOverlap) {
    PlaneScene scene = plane_scene(unchanged);
    for (std::size_t i = 0; i < scene.views.size(); i += 7)  // holes and single triangles
        scene.views[i] = i % 2 == 0 ? kNoView : std::clamp(scene.views[i] + 1, 0, 3);
    AtlasOptions options;
    options.max_side_px = 256;
    const types::Texture texture = scene.texture(options);
    EXPECT_GT(texture.atlases.size(), 1U);
    std::vector<cv::Mat> count;
    for (const cv::Mat& atlas : texture.atlases) {
        EXPECT_LE(std::max(atlas.rows, atlas.cols), 256);
        count.emplace_back(atlas.size(), CV_8UC1, cv::Scalar(0));
    }
    double texels = 0.0;
    double pixels = 0.0;
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
        EXPECT_EQ(texture.atlas_of_triangle[i] == types::Texture::kUntextured,
                  scene.views[i] == kNoView);
        if (scene.views[i] == kNoView) continue;
        cv::Mat& used = count[texture.atlas_of_triangle[i]];
        mesh::PixelTriangle corners;
        std::array<Eigen::Vector2d, 3> seen;
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector2f& uv = texture.uv[i][k];
            EXPECT_TRUE(uv.minCoeff() > 0.0F && uv.maxCoeff() < 1.0F);
            corners[k] = {uv.x() * static_cast<float>(used.cols),
                          uv.y() * static_cast<float>(used.rows),
                          0.0F};
            seen[k] =
                scene.rig.pixel(scene.keyframes[scene.views[i]].T_world_cam.inverse() *
                                scene.mesh.vertices[scene.mesh.triangles[i][k]].cast<double>());
        }
        const auto area = [](const auto& a, const auto& b, const auto& c) {
            return std::abs(static_cast<double>((b.x() - a.x()) * (c.y() - a.y()) -
                                                (b.y() - a.y()) * (c.x() - a.x())));
        };
        texels += area(corners[0], corners[1], corners[2]);
        pixels += area(seen[0], seen[1], seen[2]);
        mesh::for_each_pixel(corners,
                             used.rows,
                             used.cols,
                             [&](int row, int column, const Eigen::Vector3f& weights, float) {
                                 if (weights.minCoeff() > 1e-3F)
                                     ++used.at<std::uint8_t>(row, column);
                             });
    }
    EXPECT_NEAR(texels / pixels, scene.texture(options).texels_per_pixel, 0.01);
    for (const cv::Mat& used : count) {
        double most = 0.0;
        cv::minMaxLoc(used, nullptr, &most);
        EXPECT_LE(most, 1.0);
    }
}

TEST(TextureMesh, TrianglesOfAnImageThatCannotBeReadStayUntextured) {
    PlaneScene scene = plane_scene(with_gains);
    scene.images[1] = cv::Mat();
    scene.images[3] = cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(0));  // of another size
    const types::Texture texture = scene.texture();
    for (std::size_t i = 0; i < scene.views.size(); ++i)
        EXPECT_EQ(texture.atlas_of_triangle[i] == types::Texture::kUntextured,
                  scene.views[i] == 1 || scene.views[i] == 3);
}

TEST(TextureMesh, BadTrianglesAreLeftOutOrStayInsideTheImage) {
    PlaneScene scene = plane_scene(unchanged);
    auto& vertices = scene.mesh.vertices;
    const auto first = static_cast<std::uint32_t>(vertices.size());
    vertices.emplace_back(0.0F, 0.0F, 5.0F);  // behind the cameras
    vertices.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F);
    vertices.emplace_back(50.0F, -50.0F, 0.0F);  // beyond every image
    scene.mesh.triangles.push_back({0, 1, first});
    scene.mesh.triangles.push_back({0, 1, first + 1});
    scene.mesh.triangles.push_back({0, 1, first + 2});
    scene.mesh.triangles.push_back({0, 1, 1});  // degenerate
    scene.mesh.triangles.push_back({0, 0, 0});
    scene.views.insert(scene.views.end(), 5, 1);
    const types::Texture texture = scene.texture();
    const std::size_t num = scene.views.size();
    EXPECT_EQ(texture.atlas_of_triangle[num - 5], types::Texture::kUntextured);
    EXPECT_EQ(texture.atlas_of_triangle[num - 4], types::Texture::kUntextured);
    for (std::size_t i = num - 3; i < num; ++i)
        for (const Eigen::Vector2f& uv : texture.uv[i])
            EXPECT_TRUE(uv.minCoeff() > 0.0F && uv.maxCoeff() < 1.0F);
}

TEST(TextureMesh, TheBytesDoNotDependOnTheThreads) {
    const PlaneScene scene = plane_scene(with_backscatter);
    const types::Texture one = scene.texture({}, 1);
    const types::Texture three = scene.texture({}, 3);
    EXPECT_EQ(one.atlas_of_triangle, three.atlas_of_triangle);
    EXPECT_EQ(one.uv, three.uv);
    ASSERT_EQ(one.atlases.size(), three.atlases.size());
    for (std::size_t i = 0; i < one.atlases.size(); ++i)
        EXPECT_EQ(cv::norm(one.atlases[i], three.atlases[i], cv::NORM_INF), 0.0);
}

TEST(TextureMesh, FewerBytesMakeLargerTexelsOfTheSamePicture) {
    const PlaneScene scene = plane_scene(unchanged);
    AtlasOptions options;
    options.max_texel_bytes = 100'000;
    const types::Texture texture = scene.texture(options);
    std::size_t num_bytes = 0;
    for (const cv::Mat& atlas : texture.atlases) num_bytes += 3 * atlas.total();
    EXPECT_LE(num_bytes, 100'000U);
    EXPECT_LT(texture.texels_per_pixel, 0.7);
    double error = 0.0;
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
        const Eigen::Vector3d at = scene.center(i);
        error += (look_up_center(texture, i) - plane_color(at.x(), at.y())).cwiseAbs().mean() /
                 static_cast<double>(scene.views.size());
    }
    EXPECT_LE(error, 2.0);
}

TEST(TextureMesh, WithoutViewsThereIsNoAtlas) {
    PlaneScene scene = plane_scene(unchanged);
    std::fill(scene.views.begin(), scene.views.end(), kNoView);
    const types::Texture texture = scene.texture();
    EXPECT_TRUE(texture.atlases.empty());
    EXPECT_EQ(texture.uv.size(), scene.views.size());
    scene.mesh = {};
    scene.views = {};
    EXPECT_TRUE(scene.texture().atlas_of_triangle.empty());
}

TEST(TextureMesh, RefusesViewsOfAnotherMeshOrOtherKeyframes) {
    PlaneScene scene = plane_scene(unchanged);
    scene.views[5] = 4;
    EXPECT_THROW(scene.texture(), Error);
    scene.views.pop_back();
    EXPECT_THROW(scene.texture(), Error);
}

TEST(TextureMesh, StopsWhenItIsCancelled) {
    const PlaneScene scene = plane_scene(unchanged);
    const keyframes::ReadImage read = scene.read_image();
    const Photographs photographs(scene.rig, scene.keyframes, read);
    const auto cancel = [](const Progress& progress) {
        if (progress.fraction > 0.5) throw Error(ErrorCode::Cancelled, "stopped");
    };
    EXPECT_THROW(texture_mesh(scene.mesh, scene.views, photographs, {}, 2, cancel), Error);
}

}  // namespace
}  // namespace divemesh::texture
