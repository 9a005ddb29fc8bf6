#include "worker/io/reconstruction_folder.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "worker/io/covariance_file.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/rig_json.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Every file of a result (docs/measuring.md) apart from the images of its keyframes. The first one
// makes a folder a reconstruction.
constexpr std::string_view kFiles[] = {
    "metrics.json",
    "certificate.json",
    "report.html",
    "mesh.ply",
    "mesh.glb",
    "cloud.ply",
    "mosaic.png",
    "mosaic.pgw",
    "mosaic.json",
    "mosaic.tif",
    "mosaic.tfw",
    "heights.tif",
    "heights.tfw",
    "heights_sigma.tif",
    "trajectory.tum",
    "trajectory_causal.tum",
    "trajectory_predicted.tum",
    "trajectory_covariance.csv",
    "keyframes.json",
    // exports
    "trajectory_kitti.txt",
    "trajectory_euroc.csv",
    "mesh_obj.zip",
    "mesh_ply.zip",
    "surface.las",
    "surface.laz",
    "cloud.e57",
    "reconstruction.mcap",
    "colmap/certificate.json",
    "colmap/sparse/0/cameras.bin",
    "colmap/sparse/0/cameras.txt",
    "colmap/sparse/0/images.bin",
    "colmap/sparse/0/images.txt",
    "colmap/sparse/0/points3D.bin",
    "colmap/sparse/0/points3D.txt",
    "nerfstudio/certificate.json",
    "nerfstudio/transforms.json",
    "nerfstudio/points.ply",
    "tiles/certificate.json",
    "tiles/tileset.json",
    // the report on its accuracy
    "accuracy/report.json",
    "accuracy/report.csv",
    "accuracy/report.html",
    "accuracy/junit.xml",
    // of older versions
    "mosaic_height.png",
    "mosaic_height.pgw",
    "mosaic_height.tif",
};

// The folders with images of the keyframes, and all folders of a result, the inner ones first.
constexpr std::string_view kImageFolders[] = {"keyframes", "colmap/images", "nerfstudio/images"};
constexpr std::string_view kFolders[] = {"keyframes",
                                         "accuracy",
                                         "colmap/images",
                                         "colmap/sparse/0",
                                         "colmap/sparse",
                                         "colmap",
                                         "nerfstudio/images",
                                         "nerfstudio",
                                         "tiles"};

json read_json(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream)
        throw Error(
            ErrorCode::NotFound,
            "no " + file.filename().string() + " in " + file.parent_path().string() +
                ": give the folder that `divemesh reconstruct --out` or `divemesh download` wrote");
    json document = json::parse(stream, nullptr, false);
    if (!document.is_object())
        throw Error(ErrorCode::BadData, file.string() + " is not a JSON object");
    return document;
}

// Returns whether this is the name of a keyframe's image, e.g. 000012.jpg.
bool is_keyframe_image(const fs::path& file) {
    const std::string number = file.stem().string();
    return file.extension() == ".jpg" && number.size() >= 6 &&
           number.find_first_not_of("0123456789") == std::string::npos;
}

void remove_file(const fs::path& file) {
    std::error_code failure;
    if (fs::is_directory(fs::symlink_status(file, failure))) return;
    fs::remove(file, failure);
    if (failure && failure != std::errc::no_such_file_or_directory &&
        failure != std::errc::not_a_directory)
        throw Error(ErrorCode::Unavailable,
                    "cannot remove " + file.string() + " of an earlier result: " +
                        failure.message() + ": remove it, or give another output folder");
}

// Returns whether a file of tiles/ is a tile: root.glb, or the quadrants that lead to it.
bool is_tile(const fs::path& file) {
    const std::string name = file.stem().string();
    return file.extension() == ".glb" &&
           (name == "root" || name.find_first_not_of("0123") == std::string::npos);
}

void remove_numbered_files(const fs::path& folder, bool (*is_made)(const fs::path&)) {
    std::error_code failure;
    if (!fs::is_directory(fs::symlink_status(folder, failure))) return;
    std::vector<fs::path> files;  // a folder must not change while it is listed
    for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
         entry.increment(failure))
        if (is_made(entry->path())) files.push_back(entry->path());
    for (const fs::path& file : files) remove_file(file);
}

// Runs `read` and adds the file's name to errors, such as a field of the wrong type.
template <typename Read>
auto of_file(const std::filesystem::path& file, const Read& read) try {
    return read();
} catch (const json::exception& error) {
    throw Error(ErrorCode::BadData, file.string() + ": " + error.what());
} catch (const Error& error) {
    throw Error(ErrorCode::BadData, file.string() + ": " + error.what());
}

}  // namespace

ReconstructionFolder::ReconstructionFolder(std::filesystem::path folder)
    : folder_(std::move(folder)), metrics_(read_json(folder_ / "metrics.json")) {}

std::optional<Verdict> ReconstructionFolder::verdict() const {
    if (!metrics_.contains("verdict")) return std::nullopt;
    return of_file(folder_ / "metrics.json",
                   [&] { return verdict_from_string(metrics_.at("verdict").get<std::string>()); });
}

std::vector<std::string> ReconstructionFolder::restrictions() const {
    return of_file(folder_ / "metrics.json", [&] {
        return metrics_.value("restrictions", json::array()).get<std::vector<std::string>>();
    });
}

std::vector<Finding> ReconstructionFolder::findings() const {
    return of_file(folder_ / "metrics.json", [&] {
        return metrics_.value("findings", json::array()).get<std::vector<Finding>>();
    });
}

bool ReconstructionFolder::has_poses() const {
    std::ifstream stream(folder_ / "trajectory.tum");
    if (!stream) return true;  // reading it says what is wrong
    for (std::string line; std::getline(stream, line);)
        if (!line.empty() && line.front() != '#') return true;
    return false;
}

bool ReconstructionFolder::has_surface() const {
    return std::filesystem::exists(folder_ / "mesh.ply");
}

types::Trajectory ReconstructionFolder::trajectory() const {
    return read_trajectory(folder_ / "trajectory.tum").poses;
}

types::Trajectory ReconstructionFolder::causal_trajectory() const {
    return read_trajectory(folder_ / "trajectory_causal.tum").poses;
}

types::CovarianceTrack ReconstructionFolder::covariances() const {
    const auto file = folder_ / "trajectory_covariance.csv";
    return std::filesystem::exists(file) ? read_covariances(file) : types::CovarianceTrack();
}

types::Mesh ReconstructionFolder::mesh() const {
    types::Mesh mesh = read_ply(folder_ / "mesh.ply");
    const double simplified_m = of_file(folder_ / "metrics.json", [&] {
        return metrics_.value(json::json_pointer("/mesh/simplification/rms_m"), 0.0);
    });
    for (float& sigma_m : mesh.sigma_m)
        if (sigma_m > 0.0F) sigma_m = std::hypot(sigma_m, static_cast<float>(simplified_m));
    return mesh;
}

bool ReconstructionFolder::is_simplified() const {
    return metrics_.contains(json::json_pointer("/mesh/simplification"));
}

json ReconstructionFolder::mosaic() const { return read_json(folder_ / "mosaic.json"); }

types::Mesh ReconstructionFolder::cloud() const { return read_ply(folder_ / "cloud.ply"); }

KeyframeCamera ReconstructionFolder::keyframe_camera() const {
    const auto file = folder_ / "keyframes.json";
    const json document = read_json(file);
    return of_file(file, [&] {
        const auto center_px = document.at("principal_point_px").get<std::array<double, 2>>();
        const auto size_px = document.at("image_size_px").get<std::array<double, 2>>();
        return KeyframeCamera{document.at("focal_px").get<double>(),
                              {center_px[0], center_px[1]},
                              {size_px[0], size_px[1]}};
    });
}

std::vector<KeyframePose> ReconstructionFolder::keyframes() const {
    const auto file = folder_ / "keyframes.json";
    const json document = read_json(file);
    return of_file(file, [&] {
        std::vector<KeyframePose> keyframes;
        for (const json& entry : document.at("keyframes"))
            keyframes.push_back({entry.at("frame_index").get<int>(),
                                 entry.at("timestamp_ns").get<std::int64_t>(),
                                 pose_from_json(entry)});
        return keyframes;
    });
}

double ReconstructionFolder::matched_focal_px() const {
    const auto file = folder_ / "keyframes.json";
    if (std::filesystem::exists(file)) {
        const json document = read_json(file);
        return of_file(file, [&] { return document.at("focal_px").get<double>(); });
    }
    return of_file(folder_ / "metrics.json", [&] {
        return metrics_.value(json::json_pointer("/calibration/focal_px/0"), 0.0) /
               metrics_.value(json::json_pointer("/frames/reduction"), 1);
    });
}

std::vector<types::TrackingSegment> ReconstructionFolder::segments() const {
    return of_file(folder_ / "metrics.json", [&] {
        std::vector<types::TrackingSegment> segments;
        for (const json& stated : metrics_.value("pieces", json::array())) {
            types::TrackingSegment& segment = segments.emplace_back();
            segment.num_frames = stated.value("num_frames", std::int64_t{0});
            for (const json& interval : stated.value("intervals", json::array()))
                segment.intervals.push_back({interval.at("first_ns").get<std::int64_t>(),
                                             interval.at("last_ns").get<std::int64_t>()});
        }
        return segments;
    });
}

std::optional<Eigen::Isometry3d> ReconstructionFolder::T_imu_cam0() const {
    const json::json_pointer pointer("/calibration/T_imu_cam0");
    if (!metrics_.contains(pointer)) return std::nullopt;
    return of_file(folder_ / "metrics.json", [&] { return pose_from_json(metrics_.at(pointer)); });
}

std::optional<types::Rig> ReconstructionFolder::rig() const {
    const json::json_pointer pointer("/calibration/rig");
    if (!metrics_.contains(pointer)) return std::nullopt;
    return of_file(folder_ / "metrics.json", [&] { return rig_from_json(metrics_.at(pointer)); });
}

bool ReconstructionFolder::vertical_is_known() const {
    return of_file(folder_ / "metrics.json", [&] {
        return metrics_.value(json::json_pointer("/trajectory/vertical_known"), true);
    });
}

double ReconstructionFolder::scale_sigma() const {
    return of_file(folder_ / "metrics.json", [&] {
        return metrics_.value(json::json_pointer("/calibration/scale_sigma"),
                              types::kCalibrationSigma);
    });
}

double ReconstructionFolder::scale_contradiction() const {
    return of_file(folder_ / "metrics.json", [&] {
        return metrics_.value(json::json_pointer("/calibration/scale_contradiction"), 0.0);
    });
}

void remove_reconstruction(const fs::path& folder) {
    std::error_code failure;
    const bool is_result = fs::exists(folder / "metrics.json", failure) ||
                           fs::exists(folder / "trajectory_causal.tum", failure);
    if (!is_result) return;
    for (const std::string_view name : kFiles) remove_file(folder / name);
    for (const std::string_view images : kImageFolders)
        remove_numbered_files(folder / images, is_keyframe_image);
    remove_numbered_files(folder / "tiles", is_tile);
    for (const std::string_view emptied : kFolders) {
        std::error_code not_empty;
        if (fs::is_directory(fs::symlink_status(folder / emptied, not_empty)))
            fs::remove(folder / emptied, not_empty);
    }
}

}  // namespace divemesh::io
