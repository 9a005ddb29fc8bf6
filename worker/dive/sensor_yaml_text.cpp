#include "worker/dive/sensor_yaml_text.hpp"

#include <charconv>

#include "worker/dive/lens_yaml.hpp"

namespace divemesh::dive {
namespace {

// Writes "key: value" lines.
class Lines {
public:
    explicit Lines(int digits) : digits_(digits) {}

    void line(const std::string& line) { text_ += line + '\n'; }
    void text(const char* key, const std::string& value) { line(std::string(key) + ": " + value); }
    void number(const char* key, const std::optional<double>& value, const char* unit = "") {
        if (value) line(std::string(key) + ": " + number_text(*value) + unit);
    }
    void list(const char* key, const std::vector<double>& values, const std::string& names = "") {
        std::string row;
        for (const double value : values) row += (row.empty() ? "" : ", ") + number_text(value);
        line(std::string(key) + ": [" + row + ']' + names);
    }
    void transform(const Eigen::Matrix4d& T) {
        std::string rows;
        for (int i = 0; i < 16; ++i) {
            if (i > 0) rows += i % 4 == 0 ? ",\n         " : ", ";
            rows += number_text(T(i / 4, i % 4));
        }
        line("T_BS:\n  cols: 4\n  rows: 4\n  data: [" + rows + ']');
    }
    void port(const PortYaml& port) {
        line(
            "\n# The glass between the air before the lens and the water; intrinsics are those in "
            "air.");
        line("port:");
        text("  type", port.type);
        for (const auto& [key, values] : port.numbers)
            if (values.size() == 1)
                number(("  " + key).c_str(), values.front());
            else
                list(("  " + key).c_str(), values);
    }
    const std::string& all() const { return text_; }

private:
    std::string number_text(double value) const {
        char text[64];
        char* const end = text + sizeof text;
        const auto written =
            digits_ == 0 ? std::to_chars(text, end, value)
                         : std::to_chars(text, end, value, std::chars_format::general, digits_);
        return {text, written.ptr};
    }

    int digits_;
    std::string text_;
};

Lines begin(const std::string& type, const SensorYaml& yaml, const SensorYamlNotes& notes) {
    Lines lines(notes.digits);
    lines.line("# General sensor definitions.");
    lines.text("sensor_type", type);
    lines.text("comment", notes.comment);
    lines.line("\n# Sensor extrinsics wrt. the body-frame (sensor to body).");
    lines.transform(yaml.T_body_sensor.value_or(Eigen::Matrix4d::Identity()));
    lines.number("rate_hz", notes.rate_hz);
    return lines;
}

}  // namespace

std::string camera_yaml_text(const SensorYaml& yaml, const SensorYamlNotes& notes) {
    Lines lines = begin("camera", yaml, notes);
    lines.line("\n# Camera specific definitions.");
    lines.list("resolution", yaml.resolution);
    lines.text("camera_model", yaml.camera_model);
    const camera::LensModel* const model = camera_model_of(yaml);
    lines.list(
        "intrinsics", yaml.intrinsics, model ? " #" + intrinsics_names(*model) : std::string());
    lines.text("distortion_model", yaml.distortion_model);
    lines.list("distortion_coefficients", yaml.distortion_coefficients);
    if (yaml.port) lines.port(*yaml.port);
    return lines.all();
}

std::string imu_yaml_text(const SensorYaml& yaml, const SensorYamlNotes& notes) {
    Lines lines = begin("imu", yaml, notes);
    lines.line("\n# inertial sensor noise model parameters");
    lines.number(
        "gyroscope_noise_density", yaml.gyroscope_noise_density, "  # [ rad / s / sqrt(Hz) ]");
    lines.number(
        "gyroscope_random_walk", yaml.gyroscope_random_walk, "  # [ rad / s^2 / sqrt(Hz) ]");
    lines.number("accelerometer_noise_density",
                 yaml.accelerometer_noise_density,
                 "  # [ m / s^2 / sqrt(Hz) ]");
    lines.number(
        "accelerometer_random_walk", yaml.accelerometer_random_walk, "  # [ m / s^3 / sqrt(Hz) ]");
    return lines.all();
}

std::string sensor_yaml_text(const std::string& type,
                             const SensorYaml& yaml,
                             const SensorYamlNotes& notes) {
    return begin(type, yaml, notes).all();
}

}  // namespace divemesh::dive
