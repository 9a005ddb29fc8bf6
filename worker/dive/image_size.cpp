#include "worker/dive/image_size.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/image.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumProbed = 5;
constexpr double kMaxRounding_px = 1.0;  // sizes are whole and often even

// Returns the size of an image by its header; nullopt if it cannot be read.
std::optional<ImageSize> size_of(const DiveFiles& files, const std::string& file) {
    const auto bytes = files.read(file, kMaxImageFileBytes);
    if (!bytes) return std::nullopt;
    try {
        const ImageHeader header = read_image_header(*bytes);
        return ImageSize{header.width_px, header.height_px};
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        return std::nullopt;
    }
}

// Returns the one size of the images spread over a recording; nullopt if they differ or none can be
// read. Stops at the first that has `expected`.
std::optional<ImageSize> common_size(const DiveFiles& files,
                                     const std::vector<CameraRow>& rows,
                                     const ImageSize& expected) {
    std::optional<ImageSize> common;
    const int num_rows = static_cast<int>(rows.size());
    const int num_probed = std::min(kNumProbed, num_rows);
    for (int i = 0; i < num_probed; ++i) {
        const auto row = static_cast<std::size_t>(i * num_rows / num_probed);
        const auto size = size_of(files, rows[row].file);
        if (!size) continue;
        if (*size == expected) return size;
        if (common && *common != *size) return std::nullopt;
        common = size;
    }
    return common;
}

ImageSize size_of(const types::Camera& camera) { return {camera.width_px, camera.height_px}; }

std::string what_was_cut(const types::Camera& calibrated, const ImagePart& part) {
    const double columns =
        0.5 * (calibrated.width_px * part.scale - static_cast<double>(part.size.width_px));
    const double rows =
        0.5 * (calibrated.height_px * part.scale - static_cast<double>(part.size.height_px));
    if (rows > kMaxRounding_px)
        return " without " + base::fixed(rows, 0) + " rows above and as many below";
    if (columns > kMaxRounding_px)
        return " without " + base::fixed(columns, 0) + " columns at each side";
    return "";
}

}  // namespace

std::string to_string(const ImageSize& size) {
    return std::to_string(size.width_px) + "x" + std::to_string(size.height_px);
}

std::optional<ImagePart> part_of(const types::Camera& calibrated, const ImageSize& size) {
    if (size.width_px < 1 || size.height_px < 1) return std::nullopt;
    const double x = static_cast<double>(size.width_px) / calibrated.width_px;
    const double y = static_cast<double>(size.height_px) / calibrated.height_px;
    const double scale = std::max(x, y);
    const double cut_px =
        std::max(calibrated.width_px * scale - static_cast<double>(size.width_px),
                 calibrated.height_px * scale - static_cast<double>(size.height_px));
    if (scale > 1.0 && cut_px > kMaxRounding_px) return std::nullopt;
    return ImagePart{size, scale};
}

types::Camera camera_of(const types::Camera& calibrated, const ImagePart& part) {
    types::Camera camera = calibrated;
    camera.width_px = static_cast<int>(part.size.width_px);
    camera.height_px = static_cast<int>(part.size.height_px);
    camera.fx_px *= part.scale;
    camera.fy_px *= part.scale;
    // Pixel centres are whole numbers, so the middle of an image lies at half its size less a half.
    const auto moved = [&](double at_px, int calibrated_px, int recorded_px) {
        return (at_px + 0.5 - 0.5 * calibrated_px) * part.scale + 0.5 * recorded_px - 0.5;
    };
    camera.cx_px = moved(calibrated.cx_px, calibrated.width_px, camera.width_px);
    camera.cy_px = moved(calibrated.cy_px, calibrated.height_px, camera.height_px);
    return camera;
}

void adapt_to_image_size(const DiveFiles& files, DiveContents& contents, FindingLog& findings) {
    types::Rig& rig = contents.rig;
    const ImageSize calibrated = size_of(rig.cam0);
    if (!contents.has_rig || size_of(rig.cam1) != calibrated) return;
    const auto recorded = common_size(files, contents.left_rows, calibrated);
    if (!recorded || *recorded == calibrated) return;
    if (common_size(files, contents.right_rows, calibrated) != recorded) return;
    const auto part = part_of(rig.cam0, *recorded);
    if (!part) return;
    findings.warning("calibration_resized",
                     "mav0/cam0/sensor.yaml",
                     "the images have " + to_string(*recorded) + " pixels and the calibration " +
                         to_string(calibrated) + ": they are taken for the calibrated images at " +
                         base::fixed(part->scale, 3) + " times their size" +
                         what_was_cut(rig.cam0, *part),
                     "Calibrate in the mode in which the camera records: if that shows another "
                     "part of the sensor (digital zoom, image stabilisation, a narrower field of "
                     "view), all lengths are wrong.");
    rig.cam0 = camera_of(rig.cam0, *part);
    rig.cam1 = camera_of(rig.cam1, *part);
}

}  // namespace divemesh::dive
