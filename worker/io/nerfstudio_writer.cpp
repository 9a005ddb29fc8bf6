#include "worker/io/nerfstudio_writer.hpp"

#include <cstdint>

#include "worker/base/atomic_file.hpp"
#include "worker/io/ply.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

// Returns the rows of the pose of a camera whose y points up and whose z points back.
json transform_matrix(const Eigen::Isometry3d& T_world_cam) {
    const Eigen::Matrix4d T =
        T_world_cam.matrix() * Eigen::Vector4d(1.0, -1.0, -1.0, 1.0).asDiagonal();
    json rows = json::array();
    for (int row = 0; row < 4; ++row) rows.push_back({T(row, 0), T(row, 1), T(row, 2), T(row, 3)});
    return rows;
}

}  // namespace

void write_nerfstudio(const std::filesystem::path& folder,
                      const PosedImages& images,
                      const types::Mesh& points,
                      const std::string& remark) {
    std::filesystem::create_directories(folder);
    CloudPlyWriter cloud(folder / "points.ply", std::ssize(points.vertices), remark);
    for (std::size_t i = 0; i < points.vertices.size(); ++i)
        cloud.add(points.vertices[i], points.colors[i]);
    cloud.commit();
    json document = {{"camera_model", "OPENCV"},
                     {"fl_x", images.focal_px},
                     {"fl_y", images.focal_px},
                     {"cx", images.center_px.x()},
                     {"cy", images.center_px.y()},
                     {"w", images.width_px},
                     {"h", images.height_px},
                     {"ply_file_path", "points.ply"},
                     {"frames", json::array()}};
    for (const char* distortion : {"k1", "k2", "p1", "p2"}) document[distortion] = 0.0;
    for (const PosedImage& image : images.images)
        document["frames"].push_back({{"file_path", "images/" + image.name},
                                      {"transform_matrix", transform_matrix(image.T_world_cam)}});
    base::write_file(folder / "transforms.json", document.dump(1) + "\n");
}

}  // namespace divemesh::io
