#include "worker/dive/sensor_yaml.hpp"

#include <algorithm>
#include <cstdint>

#include "worker/dive/calibration_format.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/yaml_document.hpp"

namespace divemesh::dive {
namespace {

constexpr int kMaxNodes = 10000;

SensorYaml convert(const YAML::Node& root) {
    if (!root.IsMap()) throw YAML::ParserException(root.Mark(), "the file has no keys");
    SensorYaml yaml;
    yaml.T_body_sensor = matrix_at(root, "T_BS");
    yaml.camera_model = text_at(root, "camera_model");
    yaml.distortion_model = text_at(root, "distortion_model");
    yaml.intrinsics = numbers_at(root, "intrinsics");
    yaml.distortion_coefficients = numbers_at(root, "distortion_coefficients");
    yaml.resolution = numbers_at(root, "resolution");
    yaml.port = port_at(root);
    yaml.gyroscope_noise_density = number_at(root, "gyroscope_noise_density");
    yaml.gyroscope_random_walk = number_at(root, "gyroscope_random_walk");
    yaml.accelerometer_noise_density = number_at(root, "accelerometer_noise_density");
    yaml.accelerometer_random_walk = number_at(root, "accelerometer_random_walk");
    yaml.position_kind = text_at(root, "kind");
    yaml.epsg = number_at(root, "epsg");
    yaml.offset_sigma_m = number_at(root, "offset_sigma_m");
    return yaml;
}

// Returns the number of the first line that begins with a tab, which YAML does not allow.
std::optional<std::int64_t> line_indented_by_tab(std::string_view text) {
    for (std::int64_t line = 1; !text.empty(); ++line) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::size_t indent = text.substr(0, end).find_first_not_of(" \t");
        if (text.substr(0, std::min(indent, end)).find('\t') != std::string_view::npos) return line;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return std::nullopt;
}

}  // namespace

std::optional<SensorYaml> parse_sensor_yaml(std::string_view text,
                                            const std::string& file,
                                            FindingLog& findings) {
    if (const auto foreign = foreign_calibration(text)) {
        findings.error("calibration_unreadable",
                       file,
                       file + " is " + foreign->name + ", not a sensor.yaml",
                       foreign->remedy);
        return std::nullopt;
    }
    try {
        return convert(load_yaml(text, kMaxNodes));
    } catch (const YAML::Exception& error) {
        if (const auto line = line_indented_by_tab(text)) {
            findings.error("calibration_unreadable",
                           file + ":" + std::to_string(*line),
                           file + " cannot be read: a line is indented by a tab",
                           "Indent the lines of YAML by blanks.");
            return std::nullopt;
        }
        const bool has_line = !error.mark.is_null();
        findings.error(
            "calibration_unreadable",
            has_line ? file + ":" + std::to_string(error.mark.line + 1) : file,
            file + " cannot be read: " + printable(error.msg),
            "Write it in the format of EuRoC's sensor.yaml (T_BS, resolution, intrinsics ...).");
        return std::nullopt;
    }
}

}  // namespace divemesh::dive
