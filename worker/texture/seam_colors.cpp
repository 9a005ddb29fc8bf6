#include "worker/texture/seam_colors.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/bilinear.hpp"

namespace divemesh::texture {
namespace {

Seam seam_of(const types::Mesh& mesh,
             const SharedEdge& edge,
             const FaceViews& views,
             const Photographs& photographs) {
    constexpr float kMaxSamples = 1024.0F;
    Seam seam;
    seam.edge = edge;
    float length_px = 1.0F;
    for (std::size_t side = 0; side < 2; ++side) {
        seam.keyframes[side] = views[edge.triangles[side]];
        for (std::size_t end = 0; end < 2; ++end)
            seam.ends_px[side][end] =
                photographs.pixel(seam.keyframes[side], mesh.vertices[edge.vertices[end]])
                    .value()
                    .cast<float>();
        length_px = std::max(length_px, (seam.ends_px[side][1] - seam.ends_px[side][0]).norm());
    }
    seam.num_samples = static_cast<std::uint32_t>(std::ceil(std::min(length_px, kMaxSamples)));
    return seam;
}

SeamColors find_seams(const types::Mesh& mesh,
                      const std::vector<SharedEdge>& edges,
                      const FaceViews& views,
                      const Photographs& photographs) {
    SeamColors colors;
    std::size_t num_samples = 0;
    for (const SharedEdge& edge : edges) {
        const std::int32_t a = views[edge.triangles[0]];
        const std::int32_t b = views[edge.triangles[1]];
        if (a == b || a == kNoView || b == kNoView) continue;
        Seam seam = seam_of(mesh, edge, views, photographs);
        seam.first_sample = num_samples;
        num_samples += seam.num_samples;
        colors.seams.push_back(seam);
    }
    for (auto& samples : colors.samples) samples.resize(num_samples);
    return colors;
}

std::vector<std::vector<SeamSide>> sides_of_keyframes(const std::vector<Seam>& seams,
                                                      std::size_t num_keyframes) {
    std::vector<std::vector<SeamSide>> sides(num_keyframes);
    for (std::uint32_t i = 0; i < seams.size(); ++i)
        for (std::uint32_t side = 0; side < 2; ++side)
            sides[seams[i].keyframes[side]].push_back({i, side});
    return sides;
}

void sample_side(const cv::Mat& image, const SeamSide& at, SeamColors& colors) {
    const Seam& seam = colors.seams[at.seam];
    for (std::uint32_t i = 0; i < seam.num_samples; ++i) {
        const Eigen::Vector3f color =
            base::bilinear_color(image, seam.pixel(at.side, seam.along(i)));
        cv::Vec3b& sample = colors.samples[at.side][seam.first_sample + i];
        for (int channel = 0; channel < 3; ++channel)
            sample[channel] = cv::saturate_cast<std::uint8_t>(color[channel]);
    }
}

}  // namespace

SeamColors sample_seams(const types::Mesh& mesh,
                        const std::vector<SharedEdge>& edges,
                        const Photographs& photographs,
                        int num_threads,
                        const base::ProgressShare& progress,
                        FaceViews& views) {
    SeamColors colors = find_seams(mesh, edges, views, photographs);
    const auto sides = sides_of_keyframes(colors.seams, photographs.num_keyframes());
    std::vector<std::int32_t> with_seams;
    for (std::size_t i = 0; i < sides.size(); ++i)
        if (!sides[i].empty()) with_seams.push_back(static_cast<std::int32_t>(i));
    std::vector<std::uint8_t> is_missing(sides.size(), 0);
    photographs.for_each_image(
        with_seams, num_threads, progress, [&](std::int32_t keyframe, const cv::Mat& image) {
            is_missing[keyframe] = image.empty() ? 1 : 0;
            if (image.empty()) return;
            for (const SeamSide& side : sides[keyframe]) sample_side(image, side, colors);
        });
    for (std::int32_t& view : views)
        if (view != kNoView && is_missing[view] != 0) view = kNoView;
    std::erase_if(colors.seams, [&](const Seam& seam) {
        return is_missing[seam.keyframes[0]] != 0 || is_missing[seam.keyframes[1]] != 0;
    });
    return colors;
}

}  // namespace divemesh::texture
