#include "worker/dive/port_yaml.hpp"

#include <algorithm>

#include "worker/base/text.hpp"
#include "worker/camera/port_names.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/yaml_document.hpp"

namespace divemesh::dive {
namespace {

using types::Port;

constexpr double kMaxSize_m = 1.0;
constexpr double kMinNormalZ = 0.5;  // a port faces to the front
constexpr const char* kRemedy =
    "Write port: {type: flat, normal: [0, 0, 1], distance_m: 0.025, thickness_m: 0.006, "
    "glass_index: 1.49}, or {type: dome, centre_m: [0, 0, 0], radius_m: 0.05, thickness_m: 0.006, "
    "glass_index: 1.49}, with lengths in m from the lens's centre of projection.";

// A number of a port and the values it may have.
struct Key {
    const char* name;
    double Port::*value;
    double min;
    double max;
    std::optional<double> usual;  // nullopt: the file has to state it
};

constexpr Key kDistance = {"distance_m", &Port::distance_m, 0.0, kMaxSize_m, std::nullopt};
constexpr Key kRadius = {"radius_m", &Port::radius_m, 0.005, kMaxSize_m, std::nullopt};
constexpr Key kThickness = {"thickness_m", &Port::thickness_m, 0.0, 0.1, std::nullopt};
constexpr Key kGlass = {"glass_index", &Port::glass_index, 1.4, 2.0, std::nullopt};
constexpr Key kWater = {"water_index", &Port::water_index, 1.32, 1.36, 0.0};

// Takes the values of a port one by one; what is left in the end is not known.
class PortReader {
public:
    PortReader(const PortYaml& yaml, const std::string& file, FindingLog& findings)
        : left_(yaml.numbers), file_(file), findings_(findings) {}

    std::optional<Port> read(const std::string& type) {
        const auto shape = camera::port_shape(type);
        if (!shape) fail("the port's type is '" + printable(type) + "'; flat and dome are read");
        port_.shape = shape.value_or(Port::Shape::Flat);
        port_.shape == Port::Shape::Flat ? read_flat() : read_dome();
        for (const Key& key : {kThickness, kGlass, kWater}) read_number(key);
        if (good_ && !left_.empty())
            fail("the port has a key '" + printable(left_.begin()->first) +
                 "', which a port of this type has not");
        return good_ ? std::optional(port_) : std::nullopt;
    }

private:
    void fail(const std::string& what) {
        if (good_) findings_.error("calibration_port", file_, what, kRemedy);
        good_ = false;
    }

    void read_flat() {
        read_vector("normal", port_.normal);
        if (!(port_.normal.z() > kMinNormalZ * port_.normal.norm()))
            fail("the port's normal does not point to the front, which is z");
        port_.normal.normalize();
        read_number(kDistance);
    }

    void read_dome() {
        read_vector("centre_m", port_.centre_m);
        read_number(kRadius);
        if (good_ && !(port_.centre_m.norm() < 0.9 * port_.radius_m))
            fail("the lens is not within the dome: the port's centre is " +
                 base::significant(port_.centre_m.norm()) + " m away, its radius " +
                 base::significant(port_.radius_m) + " m");
    }

    void read_number(const Key& key) {
        const auto found = left_.extract(key.name);
        if (found.empty()) {
            if (key.usual) port_.*key.value = *key.usual;
            return key.usual ? void() : fail(std::string("the port has no ") + key.name);
        }
        const std::vector<double>& values = found.mapped();
        if (values.size() != 1 || !(values[0] >= key.min && values[0] <= key.max))
            return fail(std::string("the port's ") + key.name + " is not one number from " +
                        base::significant(key.min) + " to " + base::significant(key.max));
        port_.*key.value = values[0];
    }

    void read_vector(const char* name, Eigen::Vector3d& value) {
        const auto found = left_.extract(name);
        if (found.empty()) return fail(std::string("the port has no ") + name);
        if (found.mapped().size() != 3)
            return fail(std::string("the port's ") + name + " has " +
                        std::to_string(found.mapped().size()) + " numbers instead of 3");
        value = Eigen::Map<const Eigen::Vector3d>(found.mapped().data());
    }

    std::map<std::string, std::vector<double>> left_;
    const std::string& file_;
    FindingLog& findings_;
    Port port_;
    bool good_ = true;
};

std::vector<double> list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::optional<PortYaml> port_at(const YAML::Node& root) {
    const YAML::Node node = root["port"];
    if (!node || node.IsNull()) return std::nullopt;
    if (!node.IsMap()) throw YAML::ParserException(node.Mark(), "port has no keys");
    PortYaml port;
    for (const auto& entry : node) {
        const auto key = entry.first.as<std::string>();
        if (key == "type")
            port.type = text_at(node, key);
        else
            port.numbers[key] = entry.second.IsSequence()
                                    ? numbers_at(node, key)
                                    : std::vector<double>{number(entry.second)};
    }
    return port;
}

std::optional<types::Port> port_of(const PortYaml& yaml,
                                   const std::string& file,
                                   FindingLog& findings) {
    return PortReader(yaml, file, findings).read(yaml.type);
}

PortYaml state_port(const types::Port& port) {
    PortYaml yaml;
    yaml.type = camera::port_name(port.shape);
    if (port.shape == Port::Shape::Flat)
        yaml.numbers = {{"normal", list(port.normal)}, {kDistance.name, {port.distance_m}}};
    else
        yaml.numbers = {{"centre_m", list(port.centre_m)}, {kRadius.name, {port.radius_m}}};
    yaml.numbers[kThickness.name] = {port.thickness_m};
    yaml.numbers[kGlass.name] = {port.glass_index};
    if (port.water_index > 0.0) yaml.numbers[kWater.name] = {port.water_index};
    return yaml;
}

}  // namespace divemesh::dive
