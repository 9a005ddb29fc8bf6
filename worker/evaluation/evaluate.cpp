#include "worker/evaluation/evaluate.hpp"

#include <utility>

#include "schemas/error.hpp"
#include "worker/evaluation/surface_error.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/evaluation/truth_registration.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::evaluation {
namespace {

void require_same_pairing(const io::TrajectoryFile& estimate, const io::TrajectoryFile& reference) {
    if ((estimate.format == io::TrajectoryFormat::Kitti) !=
        (reference.format == io::TrajectoryFormat::Kitti))
        throw Error(ErrorCode::InvalidArgument,
                    "a KITTI file has no timestamps: compare it only with another KITTI file");
}

void require_no_truth_options(const TruthOptions& options) {
    if (options.solve_lever_arm || options.solve_time_offset || options.lever_arm ||
        options.time_offset_s != 0.0)
        throw Error(ErrorCode::InvalidArgument,
                    "lever arm and time offset need timestamps, but a KITTI file has none: give "
                    "TUM or EuRoC files");
}

TrajectoryError error_between(const io::TrajectoryFile& estimate,
                              const io::TrajectoryFile& reference) {
    require_same_pairing(estimate, reference);
    TrajectoryErrorOptions options;
    options.pair_by_index = estimate.format == io::TrajectoryFormat::Kitti;
    return trajectory_error(estimate.poses, reference.poses, options);
}

}  // namespace

nlohmann::json evaluate_trajectory(const std::filesystem::path& estimate,
                                   const std::filesystem::path& reference,
                                   const TrajectoryEvaluationOptions& options) {
    const io::TrajectoryFile estimated = io::read_trajectory(estimate);
    io::TrajectoryFile truth = io::read_trajectory(reference);
    require_same_pairing(estimated, truth);
    const std::string_view truth_format = io::to_string(truth.format);
    RegisteredTruth registered;
    if (truth.format == io::TrajectoryFormat::Kitti) {
        require_no_truth_options(options.truth);
        registered.poses = std::move(truth.poses);
        registered.options.pair_by_index = true;
    } else {
        registered = registered_truth(estimated.poses, std::move(truth.poses), options.truth);
    }
    const auto& [registration, poses, pairing] = registered;
    nlohmann::json json = to_metrics(trajectory_error(estimated.poses, poses, pairing));
    json["relative_pose"] = to_metrics(
        relative_pose_error(pair_poses(estimated.poses, poses, pairing), options.relative));
    if (!registration.has_orientation) json = without_rotations(std::move(json));
    json["truth"] = to_metrics(registration, options.truth);
    json["estimate_format"] = io::to_string(estimated.format);
    json["reference_format"] = truth_format;
    return json;
}

nlohmann::json evaluate_mesh(const MeshEvaluationRequest& request) {
    if (request.estimate_trajectory.has_value() != request.reference_trajectory.has_value())
        throw Error(ErrorCode::InvalidArgument,
                    "there is only one of the two trajectories: give those of both the estimate "
                    "and the reference, or neither");
    SurfaceErrorInput input;
    if (request.estimate_trajectory) {
        const io::TrajectoryFile estimated = io::read_trajectory(*request.estimate_trajectory);
        input.T_reference_world =
            error_between(estimated, io::read_trajectory(*request.reference_trajectory))
                .T_reference_surface;
        for (const types::StampedPose& pose : estimated.poses)
            input.camera_positions_world.push_back(pose.T_world_imu.translation());
    }
    const types::Mesh scene = request.scene ? io::read_mesh(*request.scene) : types::Mesh{};
    if (request.scene) {
        if (scene.triangles.empty())
            throw Error(ErrorCode::BadData,
                        request.scene->string() +
                            " has no triangles: give all true surface that a camera saw as a mesh");
        input.scene = &scene;
    }
    return to_metrics(
        surface_error(io::read_mesh(request.estimate), io::read_mesh(request.reference), input));
}

}  // namespace divemesh::evaluation
