#include "worker/texture/fill_atlases.hpp"

#include <opencv2/imgproc.hpp>

#include "worker/base/bilinear.hpp"
#include "worker/base/extend_pixels.hpp"
#include "worker/mesh/triangle_pixels.hpp"
#include "worker/stats/robust.hpp"
#include "worker/texture/seam_membrane.hpp"

namespace divemesh::texture {
namespace {

// What lies in each cutout, and the cutouts of each keyframe.
struct Contents {
    std::vector<std::vector<std::uint32_t>> triangles;
    std::vector<std::vector<SeamSide>> seams;
    std::vector<std::vector<std::uint32_t>> cutouts_of_keyframe;
    std::vector<std::int32_t> keyframes;  // those with cutouts
};

Contents list_contents(const AtlasSources& sources, const AtlasPlan& plan) {
    const auto& cutouts = sources.cutouts;
    Contents contents;
    contents.triangles.resize(cutouts.all.size());
    contents.seams.resize(cutouts.all.size());
    contents.cutouts_of_keyframe.resize(sources.photographs.num_keyframes());
    for (std::uint32_t i = 0; i < cutouts.of_triangle.size(); ++i)
        if (cutouts.of_triangle[i] != Cutouts::kNone)
            contents.triangles[cutouts.of_triangle[i]].push_back(i);
    for (std::uint32_t i = 0; i < sources.seam_colors.seams.size(); ++i)
        for (std::uint32_t side = 0; side < 2; ++side) {
            const std::uint32_t triangle = sources.seam_colors.seams[i].edge.triangles[side];
            contents.seams[cutouts.of_triangle[triangle]].push_back({i, side});
        }
    for (std::uint32_t i = 0; i < cutouts.all.size(); ++i)
        if (plan.places[i].atlas != PlacedCutout::kNoRoom)
            contents.cutouts_of_keyframe[cutouts.all[i].keyframe].push_back(i);
    for (std::size_t i = 0; i < contents.cutouts_of_keyframe.size(); ++i)
        if (!contents.cutouts_of_keyframe[i].empty())
            contents.keyframes.push_back(static_cast<std::int32_t>(i));
    return contents;
}

cv::Vec3f to_pixel(const Eigen::Vector3f& color) { return {color[0], color[1], color[2]}; }

// Returns what levelling adds to the pixels of a cutout, CV_32FC3: linear over the triangles.
cv::Mat added_over(const AtlasSources& sources,
                   const cv::Rect& pixels,
                   const std::vector<std::uint32_t>& triangles) {
    cv::Mat added(pixels.size(), CV_32FC3, cv::Scalar::all(0.0));
    cv::Mat is_uncovered(pixels.size(), CV_8UC1, cv::Scalar(255));
    const auto set = [&](int row, int column, const Eigen::Vector3f& color) {
        added.at<cv::Vec3f>(row, column) = to_pixel(color);
        is_uncovered.at<std::uint8_t>(row, column) = 0;
    };
    for (const std::uint32_t triangle : triangles) {
        mesh::PixelTriangle corners;
        Eigen::Matrix3f colors;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = sources.mesh.triangles[triangle][k];
            const std::int32_t keyframe = sources.views[triangle];
            const Eigen::Vector2d pixel =
                sources.photographs.pixel(keyframe, sources.mesh.vertices[vertex]).value();
            corners[k] = Eigen::Vector3d(pixel.x() + 0.5 - pixels.x, pixel.y() + 0.5 - pixels.y, 0)
                             .cast<float>();
            colors.col(static_cast<Eigen::Index>(k)) = sources.levelling.added_at(vertex, keyframe);
            set(static_cast<int>(corners[k].y()),
                static_cast<int>(corners[k].x()),
                colors.col(static_cast<Eigen::Index>(k)));
        }
        mesh::for_each_pixel(corners,
                             pixels.height,
                             pixels.width,
                             [&](int row, int column, const Eigen::Vector3f& weights, float) {
                                 set(row, column, colors * weights);
                             });
    }
    base::extend_pixels<cv::Vec3f>(is_uncovered, added);
    return added;
}

// Returns what both sides of the seams lack to their mean.
SeamResiduals residuals_over(const AtlasSources& sources,
                             const cv::Rect& pixels,
                             const std::vector<SeamSide>& sides) {
    SeamResiduals residuals(pixels.size());
    for (const SeamSide& at : sides) {
        const Seam& seam = sources.seam_colors.seams[at.seam];
        for (std::uint32_t i = 0; i < seam.num_samples; ++i) {
            const auto color = [&](std::size_t side) {
                return sources.levelling.color(sources.seam_colors, seam, side, i);
            };
            const Eigen::Vector3f step = color(1 - at.side) - color(at.side);
            const auto share = static_cast<float>(
                stats::tukey_weight(static_cast<double>(step.cwiseAbs().maxCoeff()), kMaxStep));
            const cv::Vec3f lacking = to_pixel(0.5F * share * step);
            const Eigen::Vector2f place =
                seam.pixel(at.side, seam.along(i)) -
                Eigen::Vector2f(static_cast<float>(pixels.x), static_cast<float>(pixels.y));
            base::for_each_bilinear(
                pixels.size(), place, [&](const cv::Point& pixel, float weight) {
                    residuals.sums.at<cv::Vec3f>(pixel) += weight * lacking;
                    residuals.weights.at<float>(pixel) += weight;
                });
        }
    }
    return residuals;
}

// Returns a rectangle of the image, CV_32FC3; beyond its edge the pixels at the edge go on.
cv::Mat pixels_of(const cv::Mat& image, const cv::Rect& pixels) {
    const cv::Rect inside = pixels & cv::Rect({}, image.size());
    cv::Mat part;
    cv::copyMakeBorder(image(inside),
                       part,
                       inside.y - pixels.y,
                       pixels.br().y - inside.br().y,
                       inside.x - pixels.x,
                       pixels.br().x - inside.br().x,
                       cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
    part.convertTo(part, CV_32FC3);
    return part;
}

// Returns a cutout as it goes to the atlas, CV_8UC3.
cv::Mat levelled_cutout(const AtlasSources& sources,
                        const Contents& contents,
                        std::uint32_t cutout,
                        const PlacedCutout& place,
                        const cv::Mat& image) {
    const Eigen::Vector3f& gain = sources.levelling.gains[sources.cutouts.all[cutout].keyframe];
    cv::Mat levelled = pixels_of(image, place.pixels);
    cv::multiply(levelled, cv::Scalar(gain[0], gain[1], gain[2]), levelled);
    levelled += added_over(sources, place.pixels, contents.triangles[cutout]);
    if (!contents.seams[cutout].empty())
        add_membrane(residuals_over(sources, place.pixels, contents.seams[cutout]), levelled);
    levelled.convertTo(levelled, CV_8UC3);
    if (levelled.size() != place.texels.size())
        cv::resize(levelled, levelled, place.texels.size(), 0, 0, cv::INTER_AREA);
    return levelled;
}

}  // namespace

FilledAtlases fill_atlases(const AtlasSources& sources,
                           const AtlasPlan& plan,
                           int num_threads,
                           const base::ProgressShare& progress) {
    FilledAtlases filled;
    for (const cv::Size& size : plan.sizes)
        filled.images.emplace_back(size, CV_8UC3, cv::Scalar::all(0.0));
    filled.is_filled.assign(plan.places.size(), 0);
    const Contents contents = list_contents(sources, plan);
    const auto fill = [&](std::int32_t keyframe, const cv::Mat& image) {
        if (image.empty()) return;
        for (const std::uint32_t cutout : contents.cutouts_of_keyframe[keyframe]) {
            const PlacedCutout& place = plan.places[cutout];
            levelled_cutout(sources, contents, cutout, place, image)
                .copyTo(filled.images[place.atlas](place.texels));
            filled.is_filled[cutout] = 1;
        }
    };
    sources.photographs.for_each_image(contents.keyframes, num_threads, progress, fill);
    return filled;
}

}  // namespace divemesh::texture
