#include "worker/dive/sensor_yaml.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <sstream>
#include <vector>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "worker/dive/calibration_format.hpp"
#include "worker/dive/entry_name.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kMaxDepth = 8;
constexpr int kMaxNodes = 10000;

// Walks through a document without building it, and stops at constructs that hostile documents use.
class Guard : public YAML::EventHandler {
public:
    void OnDocumentStart(const YAML::Mark&) override {}
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { node(mark, anchor); }
    void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
        throw YAML::ParserException(mark, "aliases are not allowed here");
    }
    void OnScalar(const YAML::Mark& mark,
                  const std::string&,
                  YAML::anchor_t anchor,
                  const std::string& value) override {
        const bool is_key = !levels_.empty() && levels_.back().at_key;
        if (is_key && !levels_.back().keys.insert(value).second)
            throw YAML::ParserException(mark, "\"" + value + "\" is stated twice");
        node(mark, anchor);
    }
    void OnSequenceStart(const YAML::Mark& mark,
                         const std::string&,
                         YAML::anchor_t anchor,
                         YAML::EmitterStyle::value) override {
        open(mark, anchor, false);
    }
    void OnSequenceEnd() override { levels_.pop_back(); }
    void OnMapStart(const YAML::Mark& mark,
                    const std::string&,
                    YAML::anchor_t anchor,
                    YAML::EmitterStyle::value) override {
        open(mark, anchor, true);
    }
    void OnMapEnd() override { levels_.pop_back(); }

private:
    void node(const YAML::Mark& mark, YAML::anchor_t anchor) {
        if (anchor != 0) throw YAML::ParserException(mark, "anchors are not allowed here");
        if (++num_nodes_ > kMaxNodes) throw YAML::ParserException(mark, "too many values");
        if (!levels_.empty() && levels_.back().is_map)
            levels_.back().at_key = !levels_.back().at_key;
    }
    void open(const YAML::Mark& mark, YAML::anchor_t anchor, bool is_map) {
        node(mark, anchor);
        if (levels_.size() >= kMaxDepth) throw YAML::ParserException(mark, "nested too deep");
        levels_.push_back({is_map, is_map, {}});
    }

    struct Level {
        bool is_map;
        bool at_key;  // the next node in a map is a key
        std::set<std::string> keys;
    };
    std::vector<Level> levels_;
    int num_nodes_ = 0;
};

// Removes the %YAML line, as OpenCV's files have one that is not valid YAML; EuRoC's have none.
std::string without_directive(std::string_view text) {
    if (!text.starts_with("%YAML")) return std::string(text);
    std::string result(text);
    for (char& c : result) {
        if (c == '\n') break;
        c = ' ';
    }
    return result;
}

YAML::Node load_guarded(const std::string& text) {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Guard guard;
    if (!parser.HandleNextDocument(guard)) return {};
    return YAML::Load(text);
}

double number(const YAML::Node& node) {
    const auto value = node.as<double>();
    if (!std::isfinite(value)) throw YAML::ParserException(node.Mark(), "not a finite number");
    return value;
}

// Appends a list of numbers, or of nested lists, as one list.
void append_numbers(const YAML::Node& node, std::vector<double>& numbers) {
    if (!node.IsSequence()) {
        numbers.push_back(number(node));
        return;
    }
    for (const auto& item : node) append_numbers(item, numbers);
}

std::vector<double> numbers_at(const YAML::Node& root, const char* key) {
    std::vector<double> numbers;
    const YAML::Node node = root[key];
    if (node && !node.IsNull()) append_numbers(node, numbers);
    return numbers;
}

std::optional<double> number_at(const YAML::Node& root, const char* key) {
    const YAML::Node node = root[key];
    if (!node || node.IsNull()) return std::nullopt;
    return number(node);
}

std::string text_at(const YAML::Node& root, const char* key) {
    const YAML::Node node = root[key];
    return node && node.IsScalar() ? node.Scalar() : "";
}

// Returns a transform of four rows, the last of which may be left out.
std::optional<Eigen::Matrix4d> matrix_at(const YAML::Node& root, const char* key) {
    const YAML::Node node = root[key];
    if (!node || node.IsNull()) return std::nullopt;
    std::vector<double> numbers;
    if (node.IsMap() && !node["data"]) throw YAML::ParserException(node.Mark(), "it has no data");
    append_numbers(node.IsMap() ? node["data"] : node, numbers);
    if (numbers.size() == 12) numbers.insert(numbers.end(), {0.0, 0.0, 0.0, 1.0});
    if (numbers.size() != 16)
        throw YAML::ParserException(
            node.Mark(),
            std::string(key) + " has " + std::to_string(numbers.size()) + " numbers, not 16");
    return Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
}

SensorYaml convert(const YAML::Node& root) {
    if (!root.IsMap()) throw YAML::ParserException(root.Mark(), "the file has no keys");
    SensorYaml yaml;
    yaml.T_body_sensor = matrix_at(root, "T_BS");
    yaml.camera_model = text_at(root, "camera_model");
    yaml.distortion_model = text_at(root, "distortion_model");
    yaml.intrinsics = numbers_at(root, "intrinsics");
    yaml.distortion_coefficients = numbers_at(root, "distortion_coefficients");
    yaml.resolution = numbers_at(root, "resolution");
    yaml.gyroscope_noise_density = number_at(root, "gyroscope_noise_density");
    yaml.gyroscope_random_walk = number_at(root, "gyroscope_random_walk");
    yaml.accelerometer_noise_density = number_at(root, "accelerometer_noise_density");
    yaml.accelerometer_random_walk = number_at(root, "accelerometer_random_walk");
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
        return convert(load_guarded(without_directive(text)));
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
