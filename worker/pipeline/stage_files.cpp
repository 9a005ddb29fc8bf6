#include "worker/pipeline/stage_files.hpp"

#include "worker/base/binary_file.hpp"

namespace divemesh::pipeline {
namespace {

// Writes a pose as its 16 doubles, also as a member of a struct.
void put_pose(base::BinaryWriter& file, const Eigen::Isometry3d& T_a_b) {
    file.put_raw(T_a_b.matrix());
}

Eigen::Isometry3d get_pose(base::BinaryReader& file) {
    Eigen::Isometry3d T_a_b;
    T_a_b.matrix() = file.get<Eigen::Matrix4d>();
    return T_a_b;
}

void put_trajectory(base::BinaryWriter& file, const types::Trajectory& trajectory) {
    file.put(static_cast<std::uint64_t>(trajectory.size()));
    for (const types::StampedPose& pose : trajectory) {
        file.put(pose.timestamp_ns);
        put_pose(file, pose.T_world_imu);
    }
}

types::Trajectory get_trajectory(base::BinaryReader& file) {
    types::Trajectory trajectory;
    const auto num_poses = file.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < num_poses && file.ok(); ++i) {
        types::StampedPose pose;
        pose.timestamp_ns = file.get<std::int64_t>();
        pose.T_world_imu = get_pose(file);
        trajectory.push_back(pose);
    }
    return trajectory;
}

void put_keyframes(base::BinaryWriter& file, const std::vector<types::Keyframe>& keyframes) {
    file.put(static_cast<std::uint64_t>(keyframes.size()));
    for (const types::Keyframe& keyframe : keyframes) {
        file.put(keyframe.frame_index);
        file.put(keyframe.timestamp_ns);
        put_pose(file, keyframe.T_world_cam);
        file.put(keyframe.segment);
    }
}

std::vector<types::Keyframe> get_keyframes(base::BinaryReader& file) {
    std::vector<types::Keyframe> keyframes;
    const auto num_keyframes = file.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < num_keyframes && file.ok(); ++i) {
        types::Keyframe keyframe;
        keyframe.frame_index = file.get<int>();
        keyframe.timestamp_ns = file.get<std::int64_t>();
        keyframe.T_world_cam = get_pose(file);
        keyframe.segment = file.get<std::int32_t>();
        keyframes.push_back(keyframe);
    }
    return keyframes;
}

void put_rig(base::BinaryWriter& file, const types::RectifiedRig& rig) {
    file.put(rig.width_px);
    file.put(rig.height_px);
    for (const double value : {rig.focal_px, rig.cx_px, rig.cy_px, rig.baseline_m}) file.put(value);
    put_pose(file, rig.T_imu_cam);
}

types::RectifiedRig get_rig(base::BinaryReader& file) {
    types::RectifiedRig rig;
    rig.width_px = file.get<int>();
    rig.height_px = file.get<int>();
    for (double* value : {&rig.focal_px, &rig.cx_px, &rig.cy_px, &rig.baseline_m})
        *value = file.get<double>();
    rig.T_imu_cam = get_pose(file);
    return rig;
}

void put_alignment(base::BinaryWriter& file, const types::ImuAlignment& alignment) {
    file.put(alignment.time_offset_s);
    file.put_raw(alignment.q_body_imu.coeffs());
}

types::ImuAlignment get_alignment(base::BinaryReader& file) {
    types::ImuAlignment alignment;
    alignment.time_offset_s = file.get<double>();
    alignment.q_body_imu.coeffs() = file.get<Eigen::Vector4d>();
    return alignment;
}

void put_calibration(base::BinaryWriter& file, const types::RefinedCalibration& calibration) {
    put_alignment(file, calibration.imu);
    file.put(calibration.time_offset_sigma_s);
    file.put_raw(calibration.rotation_sigma_rad);
    for (std::size_t side = 0; side < 2; ++side) {
        file.put_raw(calibration.lenses[side].values);
        file.put_raw(calibration.applied_lenses[side].values);
        file.put_raw(calibration.lens_sigmas[side]);
    }
    file.put(calibration.lens_shift_px);
    for (const bool applied : {calibration.time_offset_applied,
                               calibration.rotation_applied,
                               calibration.lenses_applied})
        file.put(static_cast<std::uint8_t>(applied));
}

types::RefinedCalibration get_calibration(base::BinaryReader& file) {
    types::RefinedCalibration calibration;
    calibration.imu = get_alignment(file);
    calibration.time_offset_sigma_s = file.get<double>();
    calibration.rotation_sigma_rad = file.get<Eigen::Vector3d>();
    for (std::size_t side = 0; side < 2; ++side) {
        calibration.lenses[side].values = file.get<types::LensChange::Vector>();
        calibration.applied_lenses[side].values = file.get<types::LensChange::Vector>();
        calibration.lens_sigmas[side] = file.get<types::LensChange::Vector>();
    }
    calibration.lens_shift_px = file.get<double>();
    for (bool* applied : {&calibration.time_offset_applied,
                          &calibration.rotation_applied,
                          &calibration.lenses_applied})
        *applied = file.get<std::uint8_t>() != 0;
    return calibration;
}

void put_covariances(base::BinaryWriter& file, const types::CovarianceTrack& covariances) {
    file.put(static_cast<std::uint64_t>(covariances.size()));
    for (const types::PoseCovariance& pose : covariances) {
        file.put(pose.timestamp_ns);
        file.put_raw(pose.position_m2);
        file.put_raw(pose.rotation_rad2);
    }
}

types::CovarianceTrack get_covariances(base::BinaryReader& file) {
    types::CovarianceTrack covariances;
    const auto num_poses = file.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < num_poses && file.ok(); ++i) {
        types::PoseCovariance pose;
        pose.timestamp_ns = file.get<std::int64_t>();
        pose.position_m2 = file.get<Eigen::Matrix3d>();
        pose.rotation_rad2 = file.get<Eigen::Matrix3d>();
        covariances.push_back(pose);
    }
    return covariances;
}

void put_findings(base::BinaryWriter& file, const std::vector<Finding>& findings) {
    file.put(static_cast<std::uint64_t>(findings.size()));
    for (const Finding& finding : findings) {
        file.put(finding.severity);
        for (const auto* text : {&finding.code, &finding.where, &finding.message, &finding.remedy})
            file.put_text(*text);
    }
}

std::vector<Finding> get_findings(base::BinaryReader& file) {
    std::vector<Finding> findings;
    const auto num_findings = file.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < num_findings && file.ok(); ++i) {
        Finding& finding = findings.emplace_back();
        finding.severity = file.get<Severity>();
        for (auto* text : {&finding.code, &finding.where, &finding.message, &finding.remedy})
            *text = file.get_text();
    }
    return findings;
}

// Returns a reader positioned after the matching key; nullopt if the file is not what the stage
// would make now.
std::optional<base::BinaryReader> open_stage(const std::filesystem::path& path,
                                             const std::string& key) {
    base::BinaryReader file(path);
    if (!file.ok() || file.get_text() != key || !file.ok()) return std::nullopt;
    return file;
}

template <typename T>
std::optional<T> complete(const base::BinaryReader& file, T value) {
    if (!file.at_end()) return std::nullopt;
    return value;
}

}  // namespace

void save_rig_alignment(const std::filesystem::path& path,
                        const std::string& key,
                        const types::RigAlignment& alignment) {
    base::BinaryWriter file(path);
    file.put_text(key);
    file.put(alignment.outcome);
    file.put(static_cast<std::uint8_t>(alignment.applied));
    for (const std::int32_t num :
         {alignment.num_pairs, alignment.num_matches, alignment.num_inliers, alignment.num_windows})
        file.put(num);
    file.put_raw(alignment.change.values);
    file.put_raw(alignment.sigmas);
    for (const double value : {alignment.row_shift_px,
                               alignment.row_error_px,
                               alignment.pair_error_px,
                               alignment.disparity_bias_px,
                               alignment.disparity_bias_sigma_px})
        file.put(value);
    file.commit();
}

std::optional<types::RigAlignment> load_rig_alignment(const std::filesystem::path& path,
                                                      const std::string& key) {
    auto file = open_stage(path, key);
    if (!file) return std::nullopt;
    types::RigAlignment alignment;
    alignment.outcome = file->get<types::RigAlignment::Outcome>();
    alignment.applied = file->get<std::uint8_t>() != 0;
    for (std::int32_t* num : {&alignment.num_pairs,
                              &alignment.num_matches,
                              &alignment.num_inliers,
                              &alignment.num_windows})
        *num = file->get<std::int32_t>();
    alignment.change.values = file->get<types::RigChange::Vector>();
    alignment.sigmas = file->get<types::RigChange::Vector>();
    for (double* value : {&alignment.row_shift_px,
                          &alignment.row_error_px,
                          &alignment.pair_error_px,
                          &alignment.disparity_bias_px,
                          &alignment.disparity_bias_sigma_px})
        *value = file->get<double>();
    return complete(*file, alignment);
}

void save_track(const std::filesystem::path& path,
                const std::string& key,
                const types::Track& track) {
    base::BinaryWriter file(path);
    file.put_text(key);
    put_rig(file, track.rig);
    put_trajectory(file, track.causal);
    put_trajectory(file, track.odometry);
    put_keyframes(file, track.keyframes);
    put_keyframes(file, track.mapped);
    file.put(static_cast<std::uint64_t>(track.landmarks.size()));
    for (const types::Landmark& landmark : track.landmarks) {
        file.put_raw(landmark.p_world);
        file.put_vector(landmark.observations);
    }
    put_alignment(file, track.imu_alignment);
    file.put(track.statistics);
    file.commit();
}

std::optional<types::Track> load_track(const std::filesystem::path& path, const std::string& key) {
    auto file = open_stage(path, key);
    if (!file) return std::nullopt;
    types::Track track;
    track.rig = get_rig(*file);
    track.causal = get_trajectory(*file);
    track.odometry = get_trajectory(*file);
    track.keyframes = get_keyframes(*file);
    track.mapped = get_keyframes(*file);
    const auto num_landmarks = file->get<std::uint64_t>();
    for (std::uint64_t i = 0; i < num_landmarks && file->ok(); ++i) {
        types::Landmark landmark;
        landmark.p_world = file->get<Eigen::Vector3d>();
        landmark.observations = file->get_vector<types::LandmarkObservation>();
        track.landmarks.push_back(std::move(landmark));
    }
    track.imu_alignment = get_alignment(*file);
    track.statistics = file->get<types::TrackStatistics>();
    return complete(*file, std::move(track));
}

void save_optimised_track(const std::filesystem::path& path,
                          const std::string& key,
                          const types::OptimisedTrack& track) {
    base::BinaryWriter file(path);
    file.put_text(key);
    put_trajectory(file, track.trajectory);
    put_keyframes(file, track.keyframes);
    put_keyframes(file, track.mapped);
    put_rig(file, track.rig);
    put_calibration(file, track.calibration);
    put_covariances(file, track.covariances);
    put_findings(file, track.findings);
    file.put(track.statistics);
    file.commit();
}

std::optional<types::OptimisedTrack> load_optimised_track(const std::filesystem::path& path,
                                                          const std::string& key) {
    auto file = open_stage(path, key);
    if (!file) return std::nullopt;
    types::OptimisedTrack track;
    track.trajectory = get_trajectory(*file);
    track.keyframes = get_keyframes(*file);
    track.mapped = get_keyframes(*file);
    track.rig = get_rig(*file);
    track.calibration = get_calibration(*file);
    track.covariances = get_covariances(*file);
    track.findings = get_findings(*file);
    track.statistics = file->get<types::OptimiseStatistics>();
    return complete(*file, std::move(track));
}

void save_cloud_metrics(const std::filesystem::path& path,
                        const std::string& key,
                        const CloudMetrics& metrics) {
    base::BinaryWriter file(path);
    file.put_text(key);
    file.put(metrics);
    file.commit();
}

std::optional<CloudMetrics> load_cloud_metrics(const std::filesystem::path& path,
                                               const std::string& key) {
    auto file = open_stage(path, key);
    if (!file) return std::nullopt;
    return complete(*file, file->get<CloudMetrics>());
}

void save_surface(const std::filesystem::path& path,
                  const std::string& key,
                  const Surface& surface) {
    const types::Mesh& mesh = surface.mesh;
    base::BinaryWriter file(path);
    file.put_text(key);
    file.put_vector(mesh.vertices);
    file.put_vector(mesh.normals);
    file.put_vector(mesh.colors);
    file.put_vector(mesh.sigma_m);
    file.put_vector(mesh.sigma_local_m);
    file.put_vector(mesh.num_observations);
    file.put_vector(mesh.triangles);
    file.put(surface.simplification.has_value());
    if (surface.simplification) file.put(*surface.simplification);
    file.commit();
}

std::optional<Surface> load_surface(const std::filesystem::path& path, const std::string& key) {
    auto file = open_stage(path, key);
    if (!file) return std::nullopt;
    Surface surface;
    types::Mesh& mesh = surface.mesh;
    mesh.vertices = file->get_vector<Eigen::Vector3f>();
    mesh.normals = file->get_vector<Eigen::Vector3f>();
    mesh.colors = file->get_vector<types::Color>();
    mesh.sigma_m = file->get_vector<float>();
    mesh.sigma_local_m = file->get_vector<float>();
    mesh.num_observations = file->get_vector<std::uint32_t>();
    mesh.triangles = file->get_vector<std::array<std::uint32_t, 3>>();
    if (file->get<bool>()) surface.simplification = file->get<mesh::SimplificationError>();
    return complete(*file, std::move(surface));
}

}  // namespace divemesh::pipeline
