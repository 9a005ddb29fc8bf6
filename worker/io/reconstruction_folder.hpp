#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/verdict.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"
#include "worker/types/tracking_segment.hpp"

namespace divemesh::io {

// A pose from keyframes.json; the camera is the rectified left one, z forward, x right.
struct KeyframePose {
    int frame_index = 0;
    std::int64_t timestamp_ns = 0;
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
};

// The rectified left camera of the keyframes, at the size in which their surface was matched; the
// centre of the first pixel is (0, 0). Their images in keyframes/ are smaller.
struct KeyframeCamera {
    double focal_px = 0.0;
    Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d size_px = Eigen::Vector2d::Zero();
};

// A reconstruction as written by `divemesh reconstruct --out` or downloaded, for reports,
// measurements and comparisons. Only metrics.json is read by the constructor, all else on request.
// Every reader throws Error{NotFound} that names the missing file, or Error{BadData} that describes
// the problem.
class ReconstructionFolder {
public:
    explicit ReconstructionFolder(std::filesystem::path folder);

    const std::filesystem::path& path() const { return folder_; }
    const nlohmann::json& metrics() const { return metrics_; }  // metrics.json
    // Returns what the result can be used for; nullopt for files of older versions.
    std::optional<Verdict> verdict() const;
    std::vector<std::string> restrictions() const;  // what the findings restrict
    std::vector<Finding> findings() const;          // on the dive and on the result
    bool has_poses() const;                         // false if nothing was tracked
    bool has_surface() const;                       // false with --set surface=false
    types::Trajectory trajectory() const;           // T_world_imu, final
    types::Trajectory causal_trajectory() const;
    types::CovarianceTrack covariances() const;  // of trajectory(); empty: unknown
    // Returns mesh.ply, with normals, sigma and observation counts. Sigma includes the error of its
    // simplification, sigma_local_m does not: it is noise alone.
    types::Mesh mesh() const;
    bool is_simplified() const;  // mesh.ply has fewer triangles than were reconstructed
    types::Mesh cloud() const;   // cloud.ply, points with colours
    std::vector<KeyframePose> keyframes() const;
    KeyframeCamera keyframe_camera() const;
    // Returns the focal length of the rectified images, px, in which the surface was matched.
    // Without keyframes.json it returns that of the left camera at the size the images were read.
    double matched_focal_px() const;  // 0: unknown
    nlohmann::json mosaic() const;    // mosaic.json
    // Returns the frames and the intervals of the segments in the order of their numbers; empty for
    // files of older versions.
    std::vector<types::TrackingSegment> segments() const;
    // Returns the pose of the left camera on the body; nullopt for files of older versions.
    std::optional<Eigen::Isometry3d> T_imu_cam0() const;
    // Returns the rig that the poses belong to; nullopt for files of older versions.
    std::optional<types::Rig> rig() const;
    // Returns whether a sensor tells which way is up, so that z is the vertical; true for files of
    // older versions, which do not state it.
    bool vertical_is_known() const;
    double scale_sigma() const;  // of all lengths, relative
    // Returns the relative difference of another measurement of lengths that contradicts the scale,
    // as scale_sigma(), covariances() and mesh() contain it; 0: none does.
    double scale_contradiction() const;

private:
    std::filesystem::path folder_;
    nlohmann::json metrics_;
};

// Removes the files of an earlier result from a folder, metrics.json first: those that
// `divemesh reconstruct` writes, their exports and the report in accuracy/. Keeps all other files,
// and every folder that is not empty afterwards. Throws Error{Unavailable} if a file cannot be
// removed.
void remove_reconstruction(const std::filesystem::path& folder);

}  // namespace divemesh::io
