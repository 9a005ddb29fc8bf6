#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "worker/recording/camera_sides.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/image_folders.hpp"
#include "worker/recording/image_pairs.hpp"
#include "worker/recording/image_times.hpp"
#include "worker/recording/import_recording.hpp"
#include "worker/recording/kitti_calibration.hpp"
#include "worker/recording/stored_image.hpp"

namespace divemesh::recording {

struct StillsOptions {
    std::vector<std::filesystem::path>
        folders;  // or archives: one, or that of the left camera and the right one
    std::filesystem::path scratch;  // folder for what archives hold
    Links links = Links::LeaveOut;
    std::filesystem::path out;                       // folder of the dive, which must not exist
    std::vector<std::filesystem::path> calibration;  // as read_rig() takes them; none: as found
    bool is_uncalibrated = false;                    // none is looked for: the dive has none
    std::optional<double> metres_per_unit;           // of T in them
    NamedFolders cameras;
    std::string imu;  // "none": the IMU is left out
    TimeOptions times;
    PixelOptions pixels;
    Naming naming = Naming::AfterFile;
    base::Durability durability = base::Durability::Synced;
};

// Turns folders of images into a dive in EuRoC layout: stills of two cameras, KITTI's odometry and
// raw data, and EuRoC's layout as other programs write it. One image at a time is in memory.
class StillsImport {
public:
    // Lists the folders, tells the cameras apart, and finds times and pairs. Throws Error as
    // find_camera_sides(), find_image_times() and pair_images() do.
    StillsImport(StillsOptions options, const base::ProgressCallback& progress);

    const CameraSides& sides() const { return sides_; }
    // Writes the dive. Throws Error{BadData} if there is no calibration, Error{InvalidArgument} if
    // it is for images of another size, and as DiveWriter does. An image that cannot be read is
    // left out with a warning.
    ImportCounts write(const base::ProgressCallback& progress);
    const std::vector<Finding>& findings() const { return findings_.all(); }

private:
    RigFiles find_rig();
    ImageSize image_size(const std::vector<dive::CameraRow>& rows, const char* camera) const;
    void add_sensors(const RigFiles& rig, DiveWriter& writer);

    StillsOptions options_;
    dive::FindingLog findings_;
    ImageFolders folders_;
    CameraSides sides_;
    PairedImages images_;
};

}  // namespace divemesh::recording
