#include "worker/recording/opencv_calibration.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/yaml_document.hpp"
#include "worker/recording/baseline_unit.hpp"

namespace divemesh::recording {
namespace {

// Tangential coefficients of lenses are smaller; those of a fisheye in their places often are not.
constexpr double kMaxTangential = 0.01;

constexpr std::array<std::string_view, 9> kMatrixNames = {
    "m", "k", "cm", "mtx", "cameramatrix", "cammatrix", "cammat", "intrinsic", "intrinsics"};
constexpr std::array<std::string_view, 9> kDistortionNames = {"d",
                                                              "dist",
                                                              "distcoeffs",
                                                              "distcoeff",
                                                              "distcoef",
                                                              "distortion",
                                                              "distortioncoefficients",
                                                              "distortioncoeffs",
                                                              "distortionvector"};
constexpr std::array<std::string_view, 5> kRotationNames = {
    "r", "rot", "rotation", "rotationmatrix", "rmat"};
constexpr std::array<std::string_view, 5> kTranslationNames = {
    "t", "trans", "translation", "translationvector", "tvec"};
constexpr std::array<std::string_view, 4> kSizeNames = {
    "imagesize", "imgsize", "size", "resolution"};

// The ways in which names tell cameras apart, left and right: of K0, K1 and K2 the first two.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kSides = {
    {{"left", "right"}, {"l", "r"}, {"0", "1"}, {"1", "2"}}};

// Returns a name without what people write differently: small letters and digits alone.
std::string plain(std::string_view name) {
    std::string result;
    for (const char c : name) {
        if (c >= 'A' && c <= 'Z') result += static_cast<char>(c - 'A' + 'a');
        if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) result += c;
    }
    return result;
}

// The values of a file by their plain names.
class Values {
public:
    explicit Values(const YAML::Node& root) : root_(root) {
        for (const auto& entry : root)
            if (entry.first.IsScalar())
                names_.try_emplace(plain(entry.first.Scalar()), entry.first.Scalar());
    }

    // Returns the numbers of the first name that is there, beside a word for a side.
    template <std::size_t N>
    std::vector<double> numbers(const std::array<std::string_view, N>& names,
                                std::string_view side = "") const {
        for (const std::string_view name : names)
            for (const std::string& key :
                 {std::string(name).append(side), std::string(side).append(name)})
                if (const auto found = names_.find(key); found != names_.end())
                    return dive::numbers_at(root_, found->second);
        return {};
    }
    std::string text(const char* name) const {
        const auto found = names_.find(name);
        return found == names_.end() ? "" : dive::text_at(root_, found->second);
    }

private:
    const YAML::Node& root_;
    std::map<std::string, std::string> names_;
};

std::vector<double> resolution_of(const Values& values) {
    for (const auto& [width, height] : {std::pair("imagewidth", "imageheight"),
                                        std::pair("width", "height"),
                                        std::pair("imgwidth", "imgheight")}) {
        const auto columns = values.numbers(std::array<std::string_view, 1>{width});
        const auto rows = values.numbers(std::array<std::string_view, 1>{height});
        if (columns.size() == 1 && rows.size() == 1) return {columns[0], rows[0]};
    }
    return values.numbers(kSizeNames);
}

bool is_fisheye(const Values& values) {
    const std::string model = plain(values.text("distortionmodel"));
    const std::string flag = values.text("fisheyemodel") + values.text("fisheye");
    return model == "fisheye" || model == "equidistant" || flag == "1" || flag == "true";
}

void warn_of_fisheye(const std::vector<double>& k,
                     const std::string& file,
                     dive::FindingLog& findings) {
    if (k.size() != 4 || std::max(std::abs(k[2]), std::abs(k[3])) <= kMaxTangential) return;
    findings.warning("calibration_model_assumed",
                     file,
                     "the distortion " + base::significant(k[0]) + ", " + base::significant(k[1]) +
                         ", " + base::significant(k[2]) + ", " + base::significant(k[3]) +
                         " is taken as k1 k2 p1 p2 of the radial-tangential model",
                     "If cv::fisheye computed it, add the line fisheye_model: 1 to the file.");
}

std::optional<dive::SensorYaml> read_camera(const Values& values,
                                            std::string_view side,
                                            const std::string& file,
                                            dive::FindingLog& findings) {
    const auto k = values.numbers(kMatrixNames, side);
    if (k.empty()) return std::nullopt;
    if (k.size() != 9 || k[3] != 0.0 || k[6] != 0.0 || k[7] != 0.0 || k[8] != 1.0)
        throw Error(ErrorCode::BadData,
                    file +
                        ": a camera matrix is not fx 0 cx, 0 fy cy, 0 0 1: write the nine numbers "
                        "by rows (Matlab's are by columns)");
    dive::SensorYaml yaml;
    yaml.camera_model = "pinhole";
    yaml.intrinsics = {k[0], k[4], k[2], k[5]};
    yaml.distortion_coefficients = values.numbers(kDistortionNames, side);
    yaml.distortion_model = "radial-tangential";
    if (yaml.distortion_coefficients.empty())
        yaml.distortion_model = "none";
    else if (is_fisheye(values))
        yaml.distortion_model = "equidistant";
    else
        warn_of_fisheye(yaml.distortion_coefficients, file, findings);
    yaml.resolution = resolution_of(values);
    return yaml;
}

void read_cameras(const Values& values,
                  const std::string& file,
                  CalibrationParts& parts,
                  dive::FindingLog& findings) {
    for (const auto& [left, right] : kSides) {
        if (values.numbers(kMatrixNames, left).empty()) continue;
        if (values.numbers(kMatrixNames, right).empty()) continue;
        parts.left = read_camera(values, left, file, findings);
        parts.right = read_camera(values, right, file, findings);
        return;
    }
    if (auto camera = read_camera(values, "", file, findings))
        parts.unsided.push_back(std::move(*camera));
}

}  // namespace

std::optional<CalibrationParts> read_opencv_calibration(const YAML::Node& root,
                                                        const std::string& file,
                                                        const RigHints& hints,
                                                        dive::FindingLog& findings) {
    if (!root.IsMap()) return std::nullopt;
    const Values values(root);
    CalibrationParts parts;
    read_cameras(values, file, parts, findings);
    const auto rotation = values.numbers(kRotationNames);
    const auto translation = values.numbers(kTranslationNames);
    if (!rotation.empty() && !translation.empty()) {
        Eigen::Matrix4d T = transform_of(rotation, translation, file);
        const Eigen::Vector3d t = T.topRightCorner<3, 1>();
        T.topRightCorner<3, 1>() = t * metres_per_unit(t, hints.metres_per_unit, file, findings);
        parts.T_cam1_cam0 = T;
    }
    if (!parts.left && parts.unsided.empty() && !parts.T_cam1_cam0) return std::nullopt;
    return parts;
}

}  // namespace divemesh::recording
