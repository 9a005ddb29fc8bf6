#include "worker/recording/kwiver_calibration.hpp"

#include "schemas/error.hpp"
#include "worker/dive/yaml_document.hpp"
#include "worker/recording/baseline_unit.hpp"

namespace divemesh::recording {
namespace {

constexpr double kMinSquare_mm = 1.0;  // of a board; smaller ones were given in m

dive::SensorYaml read_camera(const YAML::Node& root,
                             const std::string& side,
                             const std::string& file) {
    const auto value = [&](const std::string& name) {
        return dive::number_at(root, name + '_' + side);
    };
    const auto needed = [&](const char* name) {
        if (const auto number = value(name)) return *number;
        throw Error(ErrorCode::BadData,
                    file + " states no " + name + '_' + side + ": write the calibration again");
    };
    dive::SensorYaml yaml;
    yaml.camera_model = "pinhole";
    yaml.intrinsics = {needed("fx"), needed("fy"), needed("cx"), needed("cy")};
    yaml.distortion_model = "radial-tangential";
    for (const char* name : {"k1", "k2", "p1", "p2", "k3"})
        yaml.distortion_coefficients.push_back(value(name).value_or(0.0));
    const auto width = dive::number_at(root, "image_width");
    const auto height = dive::number_at(root, "image_height");
    if (width && height) yaml.resolution = {*width, *height};
    return yaml;
}

// Returns the unit of T: mm, as VIAME writes it, where the squares of the board are some mm large.
std::optional<double> stated_unit(const YAML::Node& root, const RigHints& hints) {
    if (hints.metres_per_unit) return hints.metres_per_unit;
    const double square_mm = dive::number_at(root, "square_size_mm").value_or(0.0);
    return square_mm >= kMinSquare_mm ? std::optional(1e-3) : std::nullopt;
}

}  // namespace

CalibrationParts read_kwiver_calibration(const YAML::Node& root,
                                         const std::string& file,
                                         const RigHints& hints,
                                         dive::FindingLog& findings) {
    CalibrationParts parts;
    parts.left = read_camera(root, "left", file);
    parts.right = read_camera(root, "right", file);
    const auto translation = dive::numbers_at(root, "T");
    if (translation.empty()) return parts;
    Eigen::Matrix4d T = transform_of(dive::numbers_at(root, "R"), translation, file);
    const Eigen::Vector3d t = T.topRightCorner<3, 1>();
    T.topRightCorner<3, 1>() = t * metres_per_unit(t, stated_unit(root, hints), file, findings);
    parts.T_cam1_cam0 = T;
    return parts;
}

}  // namespace divemesh::recording
