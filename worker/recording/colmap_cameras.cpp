#include "worker/recording/colmap_cameras.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "schemas/error.hpp"
#include "worker/dive/entry_name.hpp"

namespace divemesh::recording {
namespace {

constexpr std::size_t kMaxParameters = 16;
// COLMAP's upper left pixel has its centre at (0.5, 0.5), OpenCV's at (0, 0).
constexpr double kPixelCentre_px = 0.5;

// A model of COLMAP that is one of ours.
struct ColmapModel {
    std::size_t num_focal;  // 1: f, 2: fx and fy
    std::size_t num_coefficients;
    const char* distortion;
};

const std::map<std::string, ColmapModel>& models() {
    static const std::map<std::string, ColmapModel> kAll = {
        {"SIMPLE_PINHOLE", {1, 0, "none"}},
        {"PINHOLE", {2, 0, "none"}},
        {"SIMPLE_RADIAL", {1, 1, "radial-tangential"}},
        {"RADIAL", {1, 2, "radial-tangential"}},
        {"OPENCV", {2, 4, "radial-tangential"}},
        {"FULL_OPENCV", {2, 8, "radial-tangential"}},
        {"SIMPLE_RADIAL_FISHEYE", {1, 1, "equidistant"}},
        {"RADIAL_FISHEYE", {1, 2, "equidistant"}},
        {"OPENCV_FISHEYE", {2, 4, "equidistant"}}};
    return kAll;
}

[[noreturn]] void fail(const std::string& file, int line, const std::string& what) {
    throw Error(ErrorCode::BadData, file + ":" + std::to_string(line) + ": " + what);
}

dive::SensorYaml read_camera(std::istringstream& row, const std::string& file, int line) {
    std::string name;
    dive::SensorYaml yaml;
    yaml.resolution.resize(2);
    row >> name >> yaml.resolution[0] >> yaml.resolution[1];
    const auto model = models().find(name);
    if (row.fail() || model == models().end())
        fail(file,
             line,
             "the camera model '" + dive::printable(name) +
                 "' is not read: let COLMAP estimate OPENCV or OPENCV_FISHEYE");
    std::vector<double> values;
    for (double value = 0.0; values.size() <= kMaxParameters && row >> value;)
        values.push_back(value);
    const auto& [num_focal, num_coefficients, distortion] = model->second;
    if (values.size() != num_focal + 2 + num_coefficients ||
        !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
        fail(file, line, "the numbers do not fit " + name + ": export the cameras again");
    yaml.camera_model = "pinhole";
    yaml.intrinsics = {values[0],
                       values[num_focal - 1],
                       values[num_focal] - kPixelCentre_px,
                       values[num_focal + 1] - kPixelCentre_px};
    yaml.distortion_model = distortion;
    yaml.distortion_coefficients.assign(values.begin() + static_cast<int>(num_focal) + 2,
                                        values.end());
    if (num_coefficients > 0)
        yaml.distortion_coefficients.resize(std::max<std::size_t>(num_coefficients, 4), 0.0);
    return yaml;
}

}  // namespace

CalibrationParts read_colmap_cameras(std::string_view text, const std::string& file) {
    std::map<int, dive::SensorYaml> cameras;
    std::istringstream rows{std::string(text)};
    std::string line;
    for (int number = 1; std::getline(rows, line); ++number) {
        std::istringstream row(line);
        int camera_id = 0;
        if (line.empty() || line[0] == '#' || line.find_first_not_of(" \t\r") == line.npos)
            continue;
        if (!(row >> camera_id))
            fail(file, number, "it has no number of a camera: export it again");
        if (!cameras.emplace(camera_id, read_camera(row, file, number)).second)
            fail(file, number, "a camera is stated twice: export the cameras again");
        if (cameras.size() > 2)
            fail(file,
                 number,
                 "it states more than two cameras: leave the left and the right one in it, the "
                 "left one with the smaller number");
    }
    CalibrationParts parts;
    for (auto& [id, camera] : cameras) parts.unsided.push_back(std::move(camera));
    return parts;
}

}  // namespace divemesh::recording
