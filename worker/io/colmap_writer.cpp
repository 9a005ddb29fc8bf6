#include "worker/io/colmap_writer.hpp"

#include <cstdint>

#include "worker/base/atomic_file.hpp"
#include "worker/base/text.hpp"
#include "worker/io/record.hpp"

namespace divemesh::io {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kCameraId = 1;  // ids count from 1
constexpr std::int32_t kPinhole = 1;    // COLMAP's number of the model: fx, fy, cx, cy
constexpr double kUnknownError_px = -1.0;

// Returns a number that reads back as the same double.
std::string exact(double value) { return base::significant(value, 17); }

struct WorldToCamera {
    Eigen::Quaterniond q_cam_world;
    Eigen::Vector3d p_cam;  // of the world's origin
};

WorldToCamera world_to_camera(const Eigen::Isometry3d& T_world_cam) {
    const Eigen::Isometry3d T_cam_world = T_world_cam.inverse();
    Eigen::Quaterniond q(T_cam_world.linear());
    q.normalize();
    if (q.w() < 0.0) q.coeffs() = -q.coeffs();
    return {q, T_cam_world.translation()};
}

void write_cameras(const fs::path& folder, const PosedImages& images, const std::string& remark) {
    const double parameters[] = {
        images.focal_px, images.focal_px, images.center_px.x(), images.center_px.y()};
    Record record;
    record.put(std::uint64_t{1});
    record.put(kCameraId);
    record.put(kPinhole);
    record.put(static_cast<std::uint64_t>(images.width_px));
    record.put(static_cast<std::uint64_t>(images.height_px));
    std::string text =
        "# Camera list with one line of data per camera:\n"
        "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
        "# Number of cameras: 1\n# " +
        remark + "\n" + std::to_string(kCameraId) + " PINHOLE " + std::to_string(images.width_px) +
        " " + std::to_string(images.height_px);
    for (const double parameter : parameters) {
        record.put(parameter);
        text.append(" ").append(exact(parameter));
    }
    base::write_file(folder / "cameras.bin", record.bytes());
    base::write_file(folder / "cameras.txt", text + "\n");
}

void put_image(Record& record, std::uint32_t id, const PosedImage& image) {
    const auto [q, p] = world_to_camera(image.T_world_cam);
    record.put(id);
    for (const double value : {q.w(), q.x(), q.y(), q.z()}) record.put(value);
    record.put(p);
    record.put(kCameraId);
    record.put_text(image.name);
    record.put(std::uint64_t{0});  // no 2D points
}

// Returns the two lines of an image; the second one, of its 2D points, is empty.
std::string image_text(std::uint32_t id, const PosedImage& image) {
    const auto [q, p] = world_to_camera(image.T_world_cam);
    std::string text = std::to_string(id);
    for (const double value : {q.w(), q.x(), q.y(), q.z(), p.x(), p.y(), p.z()})
        text.append(" ").append(exact(value));
    return text + " " + std::to_string(kCameraId) + " " + image.name + "\n\n";
}

void write_images(const fs::path& folder, const PosedImages& images, const std::string& remark) {
    const std::size_t num_images = images.images.size();
    Record record;
    record.put(static_cast<std::uint64_t>(num_images));
    std::string text =
        "# Image list with two lines of data per image:\n"
        "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
        "#   POINTS2D[] as (X, Y, POINT3D_ID)\n"
        "# Number of images: " +
        std::to_string(num_images) + ", mean observations per image: 0\n# " + remark + "\n";
    for (std::uint32_t id = 1; id <= num_images; ++id) {
        put_image(record, id, images.images[id - 1]);
        text += image_text(id, images.images[id - 1]);
    }
    base::write_file(folder / "images.bin", record.bytes());
    base::write_file(folder / "images.txt", text);
}

std::string point_text(std::uint64_t id, const Eigen::Vector3d& point, const types::Color& color) {
    std::string text = std::to_string(id);
    for (const double value : point) text.append(" ").append(exact(value));
    for (const std::uint8_t channel : color) text.append(" ").append(std::to_string(channel));
    return text + " " + exact(kUnknownError_px) + "\n";
}

void write_points(const fs::path& folder, const types::Mesh& points, const std::string& remark) {
    base::AtomicFile binary(folder / "points3D.bin");
    base::AtomicFile text(folder / "points3D.txt");
    const std::uint64_t num_points = points.vertices.size();
    Record record;
    record.put(num_points);
    text.write(
        "# 3D point list with one line of data per point:\n"
        "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
        "# Number of points: " +
        std::to_string(num_points) + ", mean track length: 0\n# " + remark + "\n");
    for (std::uint64_t id = 1; id <= num_points; ++id) {
        const Eigen::Vector3d point = points.vertices[id - 1].cast<double>();
        const types::Color& color = points.colors[id - 1];
        record.put(id);
        record.put(point);
        record.put(color);
        record.put(kUnknownError_px);
        record.put(std::uint64_t{0});  // no track
        record.flush_to(binary);
        text.write(point_text(id, point, color));
    }
    record.flush_to(binary);
    binary.commit();
    text.commit();
}

}  // namespace

void write_colmap(const fs::path& folder,
                  const PosedImages& images,
                  const types::Mesh& points,
                  const std::string& remark) {
    fs::create_directories(folder);
    write_cameras(folder, images, remark);
    write_images(folder, images, remark);
    write_points(folder, points, remark);
}

}  // namespace divemesh::io
