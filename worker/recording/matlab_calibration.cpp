#include "worker/recording/matlab_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/recording/baseline_unit.hpp"

namespace divemesh::recording {
namespace {

constexpr const char* kSaveStruct =
    "in Matlab write s = toStruct(stereoParams); save('rig.mat', '-struct', 's') and give that "
    "file";

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

// Returns the numbers of a matrix by rows; Matlab stores them by columns.
std::vector<double> by_rows(const MatValue& matrix) {
    if (matrix.num_rows == 0) return matrix.numbers;
    const std::size_t num_columns = matrix.numbers.size() / matrix.num_rows;
    std::vector<double> numbers;
    for (std::size_t row = 0; row < matrix.num_rows; ++row)
        for (std::size_t column = 0; column < num_columns; ++column)
            numbers.push_back(matrix.numbers[column * matrix.num_rows + row]);
    return numbers;
}

std::vector<double> numbers_at(const MatValue& values,
                               const std::string& name,
                               std::size_t num_numbers,
                               const std::string& where) {
    auto numbers = by_rows(values.at(name));
    const bool are_finite = std::all_of(
        numbers.begin(), numbers.end(), [](double number) { return std::isfinite(number); });
    if (numbers.size() != num_numbers || !are_finite)
        fail(where + " has no " + name + " of " + std::to_string(num_numbers) +
             " numbers: save the calibration again");
    return numbers;
}

void check_skew(double skew, const std::string& where) {
    if (skew == 0.0) return;
    fail(
        where +
        " has a skew, which the lens models do not have: calibrate without it (EstimateSkew false, "
        "est_alpha 0)");
}

// Returns the camera of numbers in OpenCV's order: fx fy cx cy and k1 k2 p1 p2 k3.
dive::SensorYaml camera_of(std::vector<double> intrinsics, std::vector<double> distortion) {
    if (distortion.size() == 5 && distortion.back() == 0.0) distortion.pop_back();
    dive::SensorYaml yaml;
    yaml.camera_model = "pinhole";
    yaml.intrinsics = std::move(intrinsics);
    yaml.distortion_model = "radial-tangential";
    yaml.distortion_coefficients = std::move(distortion);
    return yaml;
}

// Returns K by rows: older structs have IntrinsicMatrix alone, which is its transpose.
std::vector<double> camera_matrix(const MatValue& camera, const std::string& where) {
    if (camera.has("K")) return numbers_at(camera, "K", 9, where);
    auto k = numbers_at(camera, "IntrinsicMatrix", 9, where);
    std::swap(k[1], k[3]);
    std::swap(k[2], k[6]);
    std::swap(k[5], k[7]);
    return k;
}

// Reads CameraParameters1 or CameraParameters2. Their pixels begin at 1, ours at 0.
dive::SensorYaml read_parameters(const MatValue& camera, const std::string& where) {
    const auto k = camera_matrix(camera, where);
    check_skew(k[1], where);
    const std::size_t num_radial = camera.at("RadialDistortion").numbers.size() == 2 ? 2 : 3;
    const auto radial = numbers_at(camera, "RadialDistortion", num_radial, where);
    const auto tangential = numbers_at(camera, "TangentialDistortion", 2, where);
    std::vector<double> distortion = {radial[0], radial[1], tangential[0], tangential[1]};
    if (radial.size() == 3) distortion.push_back(radial[2]);
    auto yaml = camera_of({k[0], k[4], k[2] - 1.0, k[5] - 1.0}, std::move(distortion));
    const auto size = camera.at("ImageSize").numbers;  // rows, columns
    if (size.size() == 2) yaml.resolution = {size[1], size[0]};
    return yaml;
}

// Returns the unit of TranslationOfCamera2, if the struct names one that is known.
std::optional<double> world_unit_m(const MatValue& camera) {
    constexpr std::array<std::pair<const char*, double>, 8> kUnits_m = {{{"millimeters", 1e-3},
                                                                         {"mm", 1e-3},
                                                                         {"centimeters", 1e-2},
                                                                         {"cm", 1e-2},
                                                                         {"meters", 1.0},
                                                                         {"m", 1.0},
                                                                         {"inches", 0.0254},
                                                                         {"in", 0.0254}}};
    for (const auto& [unit, metres] : kUnits_m)
        if (camera.at("WorldUnits").text == unit) return metres;
    return std::nullopt;
}

Eigen::Matrix4d transform_in_m(const std::vector<double>& rotation,
                               const std::vector<double>& translation,
                               std::optional<double> unit_m,
                               const std::string& file,
                               dive::FindingLog& findings) {
    Eigen::Matrix4d T = transform_of(rotation, translation, file);
    const Eigen::Vector3d t = T.topRightCorner<3, 1>();
    T.topRightCorner<3, 1>() = t * metres_per_unit(t, unit_m, file, findings);
    return T;
}

CalibrationParts read_stereo_parameters(const MatValue& stereo,
                                        const std::string& file,
                                        const RigHints& hints,
                                        dive::FindingLog& findings) {
    const MatValue& first = stereo.at("CameraParameters1");
    CalibrationParts parts;
    parts.left = read_parameters(first, "CameraParameters1 in " + file);
    parts.right = read_parameters(stereo.at("CameraParameters2"), "CameraParameters2 in " + file);
    // [x2 y2 z2] = [x1 y1 z1] R + t: of columns the rotation is the transpose, whose rows are R's
    // columns.
    numbers_at(stereo, "RotationOfCamera2", 9, file);
    parts.T_cam1_cam0 =
        transform_in_m(stereo.at("RotationOfCamera2").numbers,
                       numbers_at(stereo, "TranslationOfCamera2", 3, file),
                       hints.metres_per_unit ? hints.metres_per_unit : world_unit_m(first),
                       file,
                       findings);
    return parts;
}

// Reads a camera of Bouguet's toolbox, whose pixels begin at 0.
dive::SensorYaml read_toolbox_camera(const MatValue& values,
                                     const std::string& side,
                                     const std::string& file) {
    const auto focal = numbers_at(values, "fc_" + side, 2, file);
    const auto centre = numbers_at(values, "cc_" + side, 2, file);
    if (values.has("alpha_c_" + side))
        check_skew(numbers_at(values, "alpha_c_" + side, 1, file)[0], "the " + side + " camera");
    const std::size_t num_kc = values.at("kc_" + side).numbers.size() == 4 ? 4 : 5;
    auto yaml = camera_of({focal[0], focal[1], centre[0], centre[1]},
                          numbers_at(values, "kc_" + side, num_kc, file));
    const auto columns = values.at("nx").numbers;
    const auto rows = values.at("ny").numbers;
    if (columns.size() == 1 && rows.size() == 1) yaml.resolution = {columns[0], rows[0]};
    return yaml;
}

CalibrationParts read_toolbox(const MatValue& values,
                              const std::string& file,
                              const RigHints& hints,
                              dive::FindingLog& findings) {
    CalibrationParts parts;
    parts.left = read_toolbox_camera(values, "left", file);
    parts.right = read_toolbox_camera(values, "right", file);
    parts.T_cam1_cam0 = transform_in_m(
        values.has("R") ? numbers_at(values, "R", 9, file) : numbers_at(values, "om", 3, file),
        numbers_at(values, "T", 3, file),
        hints.metres_per_unit,
        file,
        findings);
    return parts;
}

}  // namespace

CalibrationParts read_matlab_calibration(const MatValue& variables,
                                         const std::string& file,
                                         const RigHints& hints,
                                         dive::FindingLog& findings) {
    if (variables.has("CameraParameters1"))
        return read_stereo_parameters(variables, file, hints, findings);
    if (variables.has("fc_left")) return read_toolbox(variables, file, hints, findings);
    bool has_object = false;
    for (const auto& [name, variable] : variables.fields) {
        if (variable.has("CameraParameters1"))
            return read_stereo_parameters(variable, file, hints, findings);
        has_object = has_object || variable.is_object;
    }
    if (has_object)
        fail(file + " holds an object of a class, which Matlab alone can read: " + kSaveStruct);
    fail(file + " holds neither stereoParams as a struct nor fc_left and fc_right: " + kSaveStruct);
}

}  // namespace divemesh::recording
