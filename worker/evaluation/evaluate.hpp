#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "schemas/truth_options.hpp"
#include "worker/evaluation/relative_pose_error.hpp"

namespace divemesh::evaluation {

struct TrajectoryEvaluationOptions {
    RelativePoseOptions relative = {.delta_m = 1.0};
    TruthOptions truth;  // of the reference; not for KITTI files
};

// `divemesh evaluate trajectory`: returns the metrics of metrics.json's trajectory,
// `relative_pose`, and `truth` (lever arm and time offset) for any pair of TUM, EuRoC and KITTI
// files. KITTI files are paired line by line, which only works with another KITTI file.
nlohmann::json evaluate_trajectory(const std::filesystem::path& estimate,
                                   const std::filesystem::path& reference,
                                   const TrajectoryEvaluationOptions& options = {});

struct MeshEvaluationRequest {
    std::filesystem::path estimate;   // PLY, OBJ or GLB
    std::filesystem::path reference;  // the same formats, or only points
    // With both trajectories, the estimate is moved by the SE(3) that aligns its poses (positions
    // and orientations) with the true ones, and surface farther than 4 m from every pose is left
    // out. With neither, the meshes share a frame.
    std::optional<std::filesystem::path> estimate_trajectory;
    std::optional<std::filesystem::path> reference_trajectory;
    std::optional<std::filesystem::path> scene;  // a mesh, SurfaceErrorInput::scene
};

// `divemesh evaluate mesh`: returns the metrics of metrics.json's surface.
nlohmann::json evaluate_mesh(const MeshEvaluationRequest& request);

}  // namespace divemesh::evaluation
