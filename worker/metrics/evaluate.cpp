#include "worker/metrics/evaluate.hpp"

#include "schemas/error.hpp"
#include "worker/metrics/surface_error.hpp"
#include "worker/metrics/trajectory_error.hpp"
#include "worker/output/ply.hpp"
#include "worker/output/trajectory_file.hpp"

namespace divemesh::worker {
namespace {

TrajectoryError error_between(const TrajectoryFile& estimate, const TrajectoryFile& reference) {
    TrajectoryErrorOptions options;
    options.pair_by_index = estimate.format == TrajectoryFormat::Kitti;
    if (options.pair_by_index != (reference.format == TrajectoryFormat::Kitti))
        throw Error(ErrorCode::InvalidArgument,
                    "a KITTI file has no timestamps and can only be compared with a KITTI file");
    return trajectory_error(estimate.poses, reference.poses, options);
}

}  // namespace

nlohmann::json evaluate_trajectory(const std::filesystem::path& estimate,
                                   const std::filesystem::path& reference) {
    const TrajectoryFile estimated = read_trajectory(estimate);
    const TrajectoryFile truth = read_trajectory(reference);
    nlohmann::json json = to_metrics(error_between(estimated, truth));
    json["estimate_format"] = to_string(estimated.format);
    json["reference_format"] = to_string(truth.format);
    return json;
}

nlohmann::json evaluate_mesh(const MeshEvaluationRequest& request) {
    if (request.estimate_trajectory.has_value() != request.reference_trajectory.has_value())
        throw Error(ErrorCode::InvalidArgument,
                    "give the trajectories of both the estimate and the reference, or neither");
    SurfaceErrorInput input;
    if (request.estimate_trajectory) {
        const TrajectoryFile estimated = read_trajectory(*request.estimate_trajectory);
        input.T_reference_world =
            error_between(estimated, read_trajectory(*request.reference_trajectory))
                .T_reference_surface;
        for (const StampedPose& pose : estimated.poses)
            input.camera_positions_world.push_back(pose.T_world_imu.translation());
    }
    return to_metrics(
        surface_error(read_ply(request.estimate), read_ply(request.reference), input));
}

}  // namespace divemesh::worker
