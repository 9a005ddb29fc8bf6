#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "worker/dive/calibration.hpp"
#include "worker/recording/image_size.hpp"
#include "worker/recording/rig_messages.hpp"

namespace divemesh::recording {

// How the clock of the IMU differs from that of the cameras: t_imu = t_cam + shift_s.
struct ImuShift {
    double shift_s = 0.0;
    std::string file;  // that states it
};

// The calibration of a rig as files of a dive, and the cameras that they describe.
struct RigFiles {
    std::string cam0_yaml;  // these two are empty while the rig is not calibrated
    std::string cam1_yaml;
    std::optional<std::string> imu_yaml;  // nullopt: where the IMU is, is not known
    dive::CalibratedCamera cam0;
    dive::CalibratedCamera cam1;
    std::optional<ImuShift> imu_shift;  // nullopt: none is stated
};

// Returns a rig of which only the sizes of the images are known: that of a recording of a board.
RigFiles uncalibrated_rig(ImageSize left, ImageSize right);

// What to do where an import finds no calibration.
inline constexpr const char* kStateCalibration =
    "state it by --calibration, or, before the rig is calibrated with a board by divemesh "
    "calibrate, import with --uncalibrated";

// Whether a name of a camera or lens model can be written into a sensor.yaml: letters, '_' and '-'.
bool is_model_name(const std::string& name);

// Reads the cameras of both texts. Throws Error{BadData} with the reason if they are not a stereo
// rig.
void check_rig(RigFiles& rig, dive::FindingLog& findings);

// Reads the sensor.yaml files of another dive (of mav0/ or its parent): cam0, cam1 and imu0, if it
// is there. Throws Error{BadData} or Error{NotFound} with the reason if they are not a stereo rig.
RigFiles rig_of_folder(const std::filesystem::path& folder, dive::FindingLog& findings);

// Whether images are as the sensor recorded them, or already rectified.
enum class Rectification { Raw, Rectified };

// Returns the rig that the CameraInfo of both cameras describes, with the IMU as its body if its
// pose is known, else cam0. Without a baseline in CameraInfo the pose of cam1 is that of the
// frames; poses of frames that contradict CameraInfo are left out with a warning. Throws
// Error{BadData} with the reason if they are not those of a calibrated pair.
RigFiles rig_of_infos(const CameraInfo& left,
                      const CameraInfo& right,
                      Rectification rectification,
                      RigPoses poses,
                      dive::FindingLog& findings);

}  // namespace divemesh::recording
