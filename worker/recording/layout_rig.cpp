#include "worker/recording/layout_rig.hpp"

#include <array>

#include "schemas/error.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/recording/calibrations_beside.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kMaxCalibration_bytes = std::int64_t{1} << 20U;
constexpr std::array kKittiNames = {"calib.txt", "calib_cam_to_cam.txt"};

std::optional<RigFiles> kitti_rig(const ImageFolders& folders,
                                  const CameraSides& sides,
                                  ImageSize size,
                                  dive::FindingLog& findings) {
    const std::string& left = sides.left.front().name;
    const std::string file = folders.nearest(left, kKittiNames);
    const auto left_camera = camera_number(left);
    const auto right_camera = camera_number(sides.right.front().name);
    if (file.empty() || !left_camera || !right_camera) return std::nullopt;
    const auto infos =
        kitti_cameras(folders.read(file, kMaxCalibration_bytes), *left_camera, *right_camera, size);
    if (!infos)
        throw Error(ErrorCode::BadData,
                    dive::printable(file) + " does not describe cameras " +
                        std::to_string(*left_camera) + " and " + std::to_string(*right_camera) +
                        " with images of " + std::to_string(size.width_px) + " x " +
                        std::to_string(size.height_px) +
                        " px as KITTI does: state the calibration by --calibration");
    findings.info("calibration_found",
                  dive::printable(file),
                  "the calibration is that of cameras " + std::to_string(*left_camera) + " and " +
                      std::to_string(*right_camera) + " in " + dive::printable(file));
    return rig_of_infos(infos->left, infos->right, Rectification::Raw, RigPoses{}, findings);
}

}  // namespace

std::optional<std::string> euroc_folder(const CameraSides& sides) {
    const std::string& image = sides.left.front().name;
    const std::size_t camera = image.rfind("cam0/");
    const bool is_part = camera == 0 || (camera != std::string::npos && image[camera - 1] == '/');
    if (!is_part) return std::nullopt;
    std::string folder = image.substr(0, camera);
    const bool has_both = sides.right.front().name.starts_with(folder + "cam1/");
    return has_both ? std::optional(std::move(folder)) : std::nullopt;
}

RigFiles rig_of_layout(const std::filesystem::path& root,
                       const ImageFolders& folders,
                       const CameraSides& sides,
                       const RigHints& hints,
                       dive::FindingLog& findings) {
    const auto folder = euroc_folder(sides);
    if (folder && folders.has(*folder + "cam0/sensor.yaml") &&
        folders.has(*folder + "cam1/sensor.yaml"))
        return rig_of_folder(root / *folder, findings);
    const ImageSize size{static_cast<std::int64_t>(hints.resolution[0]),
                         static_cast<std::int64_t>(hints.resolution[1])};
    if (auto rig = kitti_rig(folders, sides, size, findings)) return std::move(*rig);
    if (const auto files = calibrations_beside(folders, findings); !files.empty())
        return rig_of_texts(files, findings, hints);
    throw Error(ErrorCode::BadData,
                std::string("the recording has no calibration that is read: ") + kStateCalibration);
}

}  // namespace divemesh::recording
