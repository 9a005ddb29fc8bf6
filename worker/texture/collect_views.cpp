#include "worker/texture/collect_views.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "worker/mesh/image_camera.hpp"
#include "worker/mesh/triangle_runs.hpp"
#include "worker/texture/depth_buffer.hpp"
#include "worker/texture/view_image.hpp"

namespace divemesh::texture {
namespace {

constexpr std::size_t kSlice = 4;        // images that are decoded at the same time
constexpr float kMinCosine = 0.1F;       // 84 degrees from the normal
constexpr float kMaxSigmas = 3.0F;       // by which two parts of one surface differ
constexpr float kMaxSize_px = 4.0F;      // of a triangle, beyond which it says no more about depth
constexpr float kNoiseSharpness = 1.0F;  // gradient of the noise, grey levels per px

// A triangle as a keyframe sees it.
struct SeenFace {
    mesh::PixelTriangle corners;
    float range_m = 0.0F;
    float cosine = 0.0F;  // of the angle between the smooth normal and the line of sight
    float tolerance_m = 0.0F;
};

// The sums over the pixels that show a triangle.
struct FaceSums {
    std::array<std::uint32_t, 3> bgr = {};
    float sharpness = 0.0F;
    std::uint32_t num = 0;

    void add(const ViewImage& image, int row, int column) {
        const auto& color = image.color.at<cv::Vec3b>(row, column);
        for (int channel = 0; channel < 3; ++channel) bgr[channel] += color[channel];
        sharpness += image.sharpness.at<float>(row, column);
        ++num;
    }
};

// What a keyframe shows of the mesh.
class View {
public:
    View(const types::Mesh& mesh,
         const std::vector<mesh::TriangleRun>& all_runs,
         const types::RectifiedRig& rig,
         const Eigen::Isometry3d& T_world_cam,
         const ViewImage& image,
         int num_threads)
        : mesh_(mesh),
          image_(image),
          camera_(rig, T_world_cam, image.color.cols, image.color.rows),
          position_world_(T_world_cam.translation().cast<float>()),
          runs_(runs_in_sight(all_runs)),
          depth_(mesh, runs_, camera_, num_threads) {}

    const std::vector<mesh::TriangleRun>& runs() const { return runs_; }

    // Returns nullopt if the image does not show all of the triangle.
    std::optional<Candidate> candidate(std::size_t face, std::uint16_t view) const {
        const std::optional<SeenFace> seen = face_in_image(face);
        if (!seen || hides_a_corner(*seen)) return std::nullopt;
        const std::optional<FaceSums> sums = sums_of(*seen);
        if (!sums) return std::nullopt;
        const float num = static_cast<float>(sums->num);
        Candidate candidate;
        candidate.view = view;
        candidate.quality = Candidate::encoded_quality(quality(*seen, sums->sharpness / num));
        for (int channel = 0; channel < 3; ++channel)
            candidate.bgr[channel] =
                static_cast<std::uint8_t>((sums->bgr[channel] + sums->num / 2) / sums->num);
        return candidate;
    }

private:
    std::vector<mesh::TriangleRun> runs_in_sight(const std::vector<mesh::TriangleRun>& runs) const {
        std::vector<mesh::TriangleRun> in_sight;
        for (const mesh::TriangleRun& run : runs)
            if (camera_.may_see(run)) in_sight.push_back(run);
        return in_sight;
    }

    bool is_in_image(const Eigen::Vector3f& pixel) const {
        return pixel.x() >= 0.0F && pixel.y() >= 0.0F &&
               pixel.x() < static_cast<float>(camera_.columns) &&
               pixel.y() < static_cast<float>(camera_.rows);
    }

    // Returns nullopt if the triangle is not all in the image, or does not face the camera.
    std::optional<SeenFace> face_in_image(std::size_t face) const {
        SeenFace seen{project_face(mesh_, camera_, face)};
        if (!is_in_front(seen.corners)) return std::nullopt;
        for (const Eigen::Vector3f& corner : seen.corners)
            if (!is_in_image(corner)) return std::nullopt;
        const auto& triangle = mesh_.triangles[face];
        const Eigen::Vector3f& a = mesh_.vertices[triangle[0]];
        const Eigen::Vector3f& b = mesh_.vertices[triangle[1]];
        const Eigen::Vector3f& c = mesh_.vertices[triangle[2]];
        const Eigen::Vector3f to_camera = position_world_ - (a + b + c) / 3.0F;
        const Eigen::Vector3f normal = (b - a).cross(c - a);
        seen.range_m = to_camera.norm();
        const float pixel_m = seen.range_m / camera_.focal_px;
        const float size_m = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
        const float cosine = normal.dot(to_camera) / (normal.norm() * seen.range_m);
        const auto smooth = smooth_cosine(triangle, to_camera / seen.range_m);
        // Noise turns a triangle that is narrower than a pixel.
        const bool is_narrow = normal.norm() < pixel_m * size_m;
        const float facing = is_narrow ? smooth.value_or(cosine) : cosine;
        if (!(facing >= kMinCosine)) return std::nullopt;  // NaN without an area
        seen.cosine = std::max(kMinCosine, smooth.value_or(cosine));
        seen.tolerance_m = kMaxSigmas * sigma_m(triangle) +
                           std::min(size_m, kMaxSize_px * pixel_m) + pixel_m / facing;
        return seen;
    }

    // Returns the cosine by the normals of the corners: those of noisy triangles would choose the
    // keyframe for each alone. Returns nullopt without normals.
    std::optional<float> smooth_cosine(const std::array<std::uint32_t, 3>& triangle,
                                       const Eigen::Vector3f& to_camera) const {
        if (mesh_.normals.empty()) return std::nullopt;
        Eigen::Vector3f normal = Eigen::Vector3f::Zero();
        for (const std::uint32_t vertex : triangle) normal += mesh_.normals[vertex];
        return normal.normalized().dot(to_camera);
    }

    // Two parts of one mesh share what neighbours share of their errors.
    float sigma_m(const std::array<std::uint32_t, 3>& triangle) const {
        const std::vector<float>& sigmas =
            mesh_.sigma_local_m.empty() ? mesh_.sigma_m : mesh_.sigma_local_m;
        if (sigmas.empty()) return 0.0F;
        return std::max({sigmas[triangle[0]], sigmas[triangle[1]], sigmas[triangle[2]]});
    }

    bool hides(int row, int column, float inverse_depth, float tolerance_m) const {
        const float nearest = depth_.inverse_depth(row, column);
        return nearest > 0.0F && 1.0F / nearest < 1.0F / inverse_depth - tolerance_m;
    }

    bool hides_a_corner(const SeenFace& seen) const {
        return std::any_of(
            seen.corners.begin(), seen.corners.end(), [&](const Eigen::Vector3f& corner) {
                return hides(static_cast<int>(corner.y()),
                             static_cast<int>(corner.x()),
                             corner.z(),
                             seen.tolerance_m);
            });
    }

    // Returns the sums over the pixels of the triangle, or its central pixel if it is too small to
    // have any; nullopt if something hides one of them.
    std::optional<FaceSums> sums_of(const SeenFace& seen) const {
        FaceSums sums;
        bool is_hidden = false;
        const auto add = [&](int row, int column, const Eigen::Vector3f&, float inverse_depth) {
            is_hidden = is_hidden || hides(row, column, inverse_depth, seen.tolerance_m);
            sums.add(image_, row, column);
        };
        mesh::for_each_pixel(seen.corners, camera_.rows, camera_.columns, add);
        if (sums.num == 0) {
            const Eigen::Vector3f center =
                (seen.corners[0] + seen.corners[1] + seen.corners[2]) / 3.0F;
            add(static_cast<int>(center.y()), static_cast<int>(center.x()), {}, center.z());
        }
        return is_hidden ? std::nullopt : std::optional(sums);
    }

    // Returns the integral of the gradient magnitude over the image of the triangle (Waechter et
    // al. 2014, after Gal et al. 2010), for each square metre of it. Reduced for grazing angles,
    // which smear, and for range, as water takes contrast. Noise must not choose where there is no
    // contrast.
    float quality(const SeenFace& seen, float sharpness) const {
        const float pixels_per_m = camera_.focal_px / seen.range_m;
        return pixels_per_m * pixels_per_m * seen.cosine * (sharpness + kNoiseSharpness) *
               seen.cosine / seen.range_m;
    }

    const types::Mesh& mesh_;
    const ViewImage& image_;
    mesh::ImageCamera camera_;
    Eigen::Vector3f position_world_;
    std::vector<mesh::TriangleRun> runs_;
    DepthBuffer depth_;
};

void add_candidates(const View& view,
                    std::uint16_t index,
                    int num_threads,
                    FaceCandidates& candidates) {
    base::for_each_index(num_threads, view.runs().size(), [&](std::size_t i) {
        for (std::size_t face = view.runs()[i].begin; face < view.runs()[i].end; ++face)
            if (const auto candidate = view.candidate(face, index))
                candidates.add(face, *candidate);
    });
}

}  // namespace

CollectedViews collect_views(const types::Mesh& mesh,
                             const types::RectifiedRig& rig,
                             const std::vector<types::Keyframe>& keyframes,
                             const keyframes::ReadImage& read_image,
                             int num_threads,
                             const base::ProgressShare& progress) {
    CollectedViews collected{FaceCandidates(mesh.triangles.size()), {}};
    const std::vector<mesh::TriangleRun> runs = mesh::triangle_runs(mesh);
    for (std::size_t begin = 0; begin < keyframes.size(); begin += kSlice) {
        std::array<ViewImage, kSlice> images;
        const std::size_t num = std::min(kSlice, keyframes.size() - begin);
        base::for_each_index(num_threads, num, [&](std::size_t i) {
            images[i] = read_view_image(read_image, keyframes[begin + i].frame_index);
        });
        for (std::size_t i = 0; i < num; ++i) {
            progress.at(static_cast<double>(begin + i) / static_cast<double>(keyframes.size()));
            const types::Keyframe& keyframe = keyframes[begin + i];
            if (images[i].is_empty()) {
                collected.lost_frames.push_back(keyframe.frame_index);
                continue;
            }
            const View view(mesh, runs, rig, keyframe.T_world_cam, images[i], num_threads);
            add_candidates(
                view, static_cast<std::uint16_t>(begin + i), num_threads, collected.candidates);
        }
    }
    return collected;
}

}  // namespace divemesh::texture
