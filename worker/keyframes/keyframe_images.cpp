#include "worker/keyframes/keyframe_images.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "worker/base/atomic_file.hpp"
#include "worker/base/parallel.hpp"

namespace divemesh::keyframes {
namespace {

constexpr std::size_t kSlice = 32;  // images between two checks for cancellation

std::string image_name(int frame_index) {
    char name[40];
    std::snprintf(name, sizeof name, "keyframes/%06d.jpg", frame_index);
    return name;
}

void write_image(const std::filesystem::path& file, const cv::Mat& image) {
    const double scale = std::min(1.0, static_cast<double>(kImageWidth_px) / image.cols);
    cv::Mat small;
    cv::resize(image, small, {}, scale, scale, cv::INTER_AREA);
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, 85});
    base::write_file(file,
                     {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()},
                     base::Durability::Unsynced);
}

nlohmann::json entry_of(const types::Keyframe& keyframe) {
    const Eigen::Vector3d p = keyframe.T_world_cam.translation();
    const Eigen::Quaterniond q(keyframe.T_world_cam.linear());
    return {{"frame_index", keyframe.frame_index},
            {"timestamp_ns", keyframe.timestamp_ns},
            {"picture", image_name(keyframe.frame_index)},
            {"position_m", {p.x(), p.y(), p.z()}},
            {"orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

}  // namespace

void write_keyframe_images(const std::filesystem::path& folder,
                           const types::RectifiedRig& rig,
                           const std::vector<types::Keyframe>& keyframes,
                           const ReadImage& read,
                           int num_threads,
                           const base::ProgressCallback& progress) {
    std::filesystem::create_directories(folder / "keyframes");
    for (std::size_t begin = 0; begin < keyframes.size(); begin += kSlice) {
        Progress done;
        done.fraction = static_cast<double>(begin) / static_cast<double>(keyframes.size());
        progress(done);
        base::for_each_index(
            num_threads, std::min(kSlice, keyframes.size() - begin), [&](std::size_t i) {
                const int frame_index = keyframes[begin + i].frame_index;
                write_image(folder / image_name(frame_index), read(frame_index));
            });
    }
    nlohmann::json list = nlohmann::json::array();
    for (const types::Keyframe& keyframe : keyframes) list.push_back(entry_of(keyframe));
    const nlohmann::json document = {
        {"frame", "world (m, z up); the camera is the rectified left one, z forward, x right"},
        {"image_size_px", {rig.width_px, rig.height_px}},
        {"focal_px", rig.focal_px},
        {"principal_point_px", {rig.cx_px, rig.cy_px}},
        {"baseline_m", rig.baseline_m},
        {"keyframes", list}};
    base::write_file(folder / "keyframes.json", document.dump(1) + "\n");
}

}  // namespace divemesh::keyframes
