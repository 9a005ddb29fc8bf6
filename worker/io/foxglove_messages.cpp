#include "worker/io/foxglove_messages.hpp"

#include "schemas/base64.hpp"
#include "worker/io/record.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

constexpr int kUint8 = 1;  // types of the fields of a cloud
constexpr int kFloat32 = 7;

json time_json(std::int64_t timestamp_ns) {
    constexpr std::int64_t kNsPerS = 1'000'000'000;
    return {{"sec", timestamp_ns / kNsPerS}, {"nsec", timestamp_ns % kNsPerS}};
}

json vector_json(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

json rotation_json(const Eigen::Isometry3d& T) {
    const Eigen::Quaterniond q(T.linear());
    return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}

json pose_json(const Eigen::Isometry3d& T) {
    return {{"position", vector_json(T.translation())}, {"orientation", rotation_json(T)}};
}

json object_schema(json properties) {
    return {{"type", "object"}, {"properties", std::move(properties)}};
}

json number_fields(std::initializer_list<const char*> names) {
    json properties = json::object();
    for (const char* name : names) properties[name] = {{"type", "number"}};
    return object_schema(std::move(properties));
}

json list_schema(json items) { return {{"type", "array"}, {"items", std::move(items)}}; }

json fields_of(std::string_view name) {
    const json text = {{"type", "string"}};
    const json number = {{"type", "number"}};
    const json integer = {{"type", "integer"}};
    const json bytes = {{"type", "string"}, {"contentEncoding", "base64"}};
    const json vector = number_fields({"x", "y", "z"});
    const json rotation = number_fields({"x", "y", "z", "w"});
    const json pose = object_schema({{"position", vector}, {"orientation", rotation}});
    if (name == "foxglove.PoseInFrame") return {{"frame_id", text}, {"pose", pose}};
    if (name == "foxglove.FrameTransform")
        return {{"parent_frame_id", text},
                {"child_frame_id", text},
                {"translation", vector},
                {"rotation", rotation}};
    if (name == "foxglove.PointCloud")
        return {
            {"frame_id", text},
            {"pose", pose},
            {"point_stride", integer},
            {"fields",
             list_schema(object_schema({{"name", text}, {"offset", integer}, {"type", integer}}))},
            {"data", bytes}};
    if (name == "foxglove.CompressedImage")
        return {{"frame_id", text}, {"data", bytes}, {"format", text}};
    return {{"frame_id", text},
            {"width", integer},
            {"height", integer},
            {"distortion_model", text},
            {"D", list_schema(number)},
            {"K", list_schema(number)},
            {"R", list_schema(number)},
            {"P", list_schema(number)}};
}

}  // namespace

json foxglove_schema(std::string_view name) {
    json properties = fields_of(name);
    properties["timestamp"] =
        object_schema({{"sec", {{"type", "integer"}}}, {"nsec", {{"type", "integer"}}}});
    properties["timestamp"]["title"] = "time";
    json schema = object_schema(std::move(properties));
    schema["title"] = name;
    return schema;
}

json pose_in_frame(std::int64_t timestamp_ns,
                   const std::string& frame,
                   const Eigen::Isometry3d& T_frame_body) {
    return {{"timestamp", time_json(timestamp_ns)},
            {"frame_id", frame},
            {"pose", pose_json(T_frame_body)}};
}

json frame_transform(std::int64_t timestamp_ns,
                     const std::string& parent,
                     const std::string& child,
                     const Eigen::Isometry3d& T_parent_child) {
    return {{"timestamp", time_json(timestamp_ns)},
            {"parent_frame_id", parent},
            {"child_frame_id", child},
            {"translation", vector_json(T_parent_child.translation())},
            {"rotation", rotation_json(T_parent_child)}};
}

json point_cloud(std::int64_t timestamp_ns, const std::string& frame, const types::Mesh& points) {
    constexpr std::uint8_t kOpaque = 255;
    Record data;
    for (std::size_t i = 0; i < points.vertices.size(); ++i) {
        data.put(points.vertices[i]);
        data.put(points.colors[i]);
        data.put(kOpaque);
    }
    json fields = json::array();
    for (const char* name : {"x", "y", "z"})
        fields.push_back(
            {{"name", name}, {"offset", sizeof(float) * fields.size()}, {"type", kFloat32}});
    for (const char* name : {"red", "green", "blue", "alpha"})
        fields.push_back(
            {{"name", name}, {"offset", 3 * sizeof(float) + fields.size() - 3}, {"type", kUint8}});
    return {{"timestamp", time_json(timestamp_ns)},
            {"frame_id", frame},
            {"pose", pose_json(Eigen::Isometry3d::Identity())},
            {"point_stride", 3 * sizeof(float) + 4},
            {"fields", std::move(fields)},
            {"data", encode_base64(data.bytes())}};
}

json compressed_image(std::int64_t timestamp_ns, const std::string& frame, std::string_view jpeg) {
    return {{"timestamp", time_json(timestamp_ns)},
            {"frame_id", frame},
            {"data", encode_base64(jpeg)},
            {"format", "jpeg"}};
}

json camera_calibration(std::int64_t timestamp_ns,
                        const std::string& frame,
                        const PosedImages& images) {
    const double f = images.focal_px;
    const Eigen::Vector2d c = images.center_px - Eigen::Vector2d::Constant(0.5);
    return {{"timestamp", time_json(timestamp_ns)},
            {"frame_id", frame},
            {"width", images.width_px},
            {"height", images.height_px},
            {"distortion_model", ""},
            {"D", json::array()},
            {"K", {f, 0, c.x(), 0, f, c.y(), 0, 0, 1}},
            {"R", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
            {"P", {f, 0, c.x(), 0, 0, f, c.y(), 0, 0, 0, 1, 0}}};
}

}  // namespace divemesh::io
