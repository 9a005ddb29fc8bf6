#include "worker/color/restored_images.hpp"

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>

#include "worker/color/surface_images.hpp"

namespace divemesh::color {
namespace {

cv::Mat restored(const cv::Mat& image,
                 const SurfaceImages& surface,
                 const mesh::ImageCamera& camera,
                 const Restorer& restorer,
                 std::size_t keyframe) {
    const std::array<float, 256>& linear = linear_levels();
    cv::Mat result(image.size(), CV_8UC3);
    for (int row = 0; row < image.rows; ++row)
        for (int column = 0; column < image.cols; ++column) {
            const auto& bgr = image.at<cv::Vec3b>(row, column);
            const float eccentricity = eccentricity_of(
                camera, static_cast<float>(column) + 0.5F, static_cast<float>(row) + 0.5F);
            const SurfaceImages::Pixel seen = surface.at(row, column);
            const RestoredColor color =
                restorer.restore({{linear[bgr[2]], linear[bgr[1]], linear[bgr[0]]},
                                  seen.range_m,
                                  eccentricity,
                                  seen.cosine},
                                 keyframe);
            result.at<cv::Vec3b>(row, column) = {
                level_of(color.rgb[2]), level_of(color.rgb[1]), level_of(color.rgb[0])};
        }
    return result;
}

}  // namespace

keyframes::ReadImage restored_images(const types::Mesh& mesh,
                                     const types::RectifiedRig& rig,
                                     const std::vector<types::Keyframe>& keyframes,
                                     const keyframes::ReadImage& read,
                                     Restorer restorer) {
    struct Known {
        SeenSurface surface;
        Restorer restorer;
        std::map<int, std::size_t> index_of_frame = {};
    };
    const auto known = std::make_shared<Known>(Known{{mesh, rig}, std::move(restorer)});
    for (std::size_t i = 0; i < keyframes.size(); ++i)
        known->index_of_frame[keyframes[i].frame_index] = i;
    return [known = std::shared_ptr<const Known>(known), &keyframes, read](int frame_index) {
        const SeenSurface& surface = known->surface;
        cv::Mat image = read(frame_index);
        const cv::Size size(surface.rig.width_px, surface.rig.height_px);
        if (image.type() != CV_8UC3 || image.size() != size) return image;
        const std::size_t keyframe = known->index_of_frame.at(frame_index);
        return restored(image,
                        SurfaceImages(surface, keyframes[keyframe]),
                        surface.camera_of(keyframes[keyframe]),
                        known->restorer,
                        keyframe);
    };
}

}  // namespace divemesh::color
