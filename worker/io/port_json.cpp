#include "worker/io/port_json.hpp"

#include <array>
#include <string>

#include "schemas/error.hpp"
#include "worker/camera/port_names.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;
using types::Port;

json list(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Vector3d vector_at(const json& entry, const char* key) {
    const auto values = entry.at(key).get<std::array<double, 3>>();
    return {values[0], values[1], values[2]};
}

}  // namespace

json to_json(const Port& port) {
    json result = {{"type", camera::port_name(port.shape)},
                   {"thickness_m", port.thickness_m},
                   {"glass_index", port.glass_index},
                   {"water_index", port.water_index},
                   {"lens_m", list(port.p_lens_cam)},
                   {"reference_depth_m", port.reference_depth_m}};
    if (port.shape == Port::Shape::Flat) {
        result["normal"] = list(port.normal);
        result["distance_m"] = port.distance_m;
    } else {
        result["centre_m"] = list(port.centre_m);
        result["radius_m"] = port.radius_m;
    }
    return result;
}

Port port_from_json(const json& entry) {
    const auto shape = camera::port_shape(entry.at("type").get<std::string>());
    if (!shape) throw Error(ErrorCode::BadData, "the type of a port is unknown");
    Port port;
    port.shape = *shape;
    port.thickness_m = entry.at("thickness_m").get<double>();
    port.glass_index = entry.at("glass_index").get<double>();
    port.water_index = entry.at("water_index").get<double>();
    port.p_lens_cam = vector_at(entry, "lens_m");
    port.reference_depth_m = entry.at("reference_depth_m").get<double>();
    if (port.shape == Port::Shape::Flat) {
        port.normal = vector_at(entry, "normal");
        port.distance_m = entry.at("distance_m").get<double>();
    } else {
        port.centre_m = vector_at(entry, "centre_m");
        port.radius_m = entry.at("radius_m").get<double>();
    }
    return port;
}

}  // namespace divemesh::io
