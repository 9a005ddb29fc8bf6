#include "worker/pipeline/stage_files.hpp"

#include <concepts>
#include <type_traits>

#include "worker/base/binary_file.hpp"

namespace divemesh::pipeline {
namespace {

// Each fields() below lists the fields of a type once, for both directions: `file` is a StageWriter
// with a const value, or a StageReader.
template <typename T, typename Type>
concept Is = std::same_as<std::remove_const_t<T>, Type>;

// Writes values in the order of the calls.
struct StageWriter {
    base::BinaryWriter& file;

    void plain(const auto& value) { file.put(value); }
    void raw(const auto& matrix) { file.put_raw(matrix); }
    void flag(bool value) { file.put(static_cast<std::uint8_t>(value)); }
    void text(const std::string& value) { file.put_text(value); }
    void vector(const auto& values) { file.put_vector(values); }
    void matrix(const Eigen::MatrixXd& values) {
        file.put(static_cast<std::uint64_t>(values.rows()));
        file.put_vector(std::vector<double>(values.data(), values.data() + values.size()));
    }
    void list(const auto& items) {
        file.put(static_cast<std::uint64_t>(items.size()));
        for (const auto& item : items) fields(*this, item);
    }
    void optional(const auto& value) {
        flag(value.has_value());
        if (value) plain(*value);
    }
};

// Reads them in the same order. The values are meaningless once file.ok() is false.
struct StageReader {
    base::BinaryReader& file;

    template <typename T>
    void plain(T& value) {
        value = file.get<T>();
    }
    template <typename T>
    void raw(T& matrix) {
        matrix = file.get<T>();
    }
    void flag(bool& value) { value = file.get<std::uint8_t>() != 0; }
    void text(std::string& value) { value = file.get_text(); }
    template <typename T>
    void vector(std::vector<T>& values) {
        values = file.get_vector<T>();
    }
    void matrix(Eigen::MatrixXd& values) {
        const auto num_rows = file.get<std::uint64_t>();
        const auto read = file.get_vector<double>();
        values.resize(0, 0);
        if (num_rows == 0 || read.size() % num_rows != 0) return;
        const auto rows = static_cast<Eigen::Index>(num_rows);
        values = Eigen::Map<const Eigen::MatrixXd>(read.data(), rows, std::ssize(read) / rows);
    }
    void list(auto& items) {
        const auto num_items = file.get<std::uint64_t>();
        for (std::uint64_t i = 0; i < num_items && file.ok(); ++i)
            fields(*this, items.emplace_back());
    }
    template <typename T>
    void optional(std::optional<T>& value) {
        bool has_value = false;
        flag(has_value);
        if (has_value) plain(value.emplace());
    }
};

void fields(auto& file, Is<types::StampedPose> auto& pose) {
    file.plain(pose.timestamp_ns);
    file.raw(pose.T_world_imu.matrix());
}

void fields(auto& file, Is<types::Keyframe> auto& keyframe) {
    file.plain(keyframe.frame_index);
    file.plain(keyframe.timestamp_ns);
    file.raw(keyframe.T_world_cam.matrix());
    file.plain(keyframe.segment);
}

void fields(auto& file, Is<types::Landmark> auto& landmark) {
    file.raw(landmark.p_world);
    file.vector(landmark.observations);
}

void fields(auto& file, Is<types::PoseCovariance> auto& pose) {
    file.plain(pose.timestamp_ns);
    file.raw(pose.position_m2);
    file.raw(pose.rotation_rad2);
}

void fields(auto& file, Is<Finding> auto& finding) {
    file.plain(finding.severity);
    for (auto* text : {&finding.code, &finding.where, &finding.message, &finding.remedy})
        file.text(*text);
}

void fields(auto& file, Is<types::RectifiedRig> auto& rig) {
    file.plain(rig.width_px);
    file.plain(rig.height_px);
    for (auto* value : {&rig.focal_px, &rig.cx_px, &rig.cy_px, &rig.baseline_m}) file.plain(*value);
    file.raw(rig.T_imu_cam.matrix());
}

void fields(auto& file, Is<types::ImuAlignment> auto& alignment) {
    file.plain(alignment.time_offset_s);
    file.raw(alignment.q_body_imu.coeffs());
    file.raw(alignment.rate_error);
}

void fields(auto& file, Is<types::SensorsLeftOut> auto& left_out) {
    file.flag(left_out.imu);
    file.flag(left_out.accelerometer);
    file.flag(left_out.ahrs);
    file.flag(left_out.pressure);
    file.vector(left_out.imu_times);
    file.vector(left_out.ahrs_times);
}

void fields(auto& file, Is<types::RefinedCalibration> auto& calibration) {
    fields(file, calibration.imu);
    file.plain(calibration.time_offset_sigma_s);
    file.raw(calibration.rotation_sigma_rad);
    for (std::size_t side = 0; side < 2; ++side) {
        file.raw(calibration.lenses[side].values);
        file.raw(calibration.lens_sigmas[side]);
    }
    file.plain(calibration.lens_shift_px);
    file.flag(calibration.time_offset_applied);
    file.plain(calibration.tracked_time_offset_s);
    file.flag(calibration.rotation_applied);
    file.raw(calibration.rate_error_sigma);
    file.flag(calibration.rate_error_applied);
    file.raw(calibration.lever_arm_m);
    file.raw(calibration.lever_arm_sigma_m);
    file.flag(calibration.lever_arm_applied);
    file.flag(calibration.lenses_applied);
    file.plain(calibration.readout_time_s);
    file.plain(calibration.readout_time_sigma_s);
    file.plain(calibration.readout_shift_px);
    file.flag(calibration.readout_time_applied);
}

void fields(auto& file, Is<types::RigPart> auto& part) {
    file.plain(part.first_frame);
    file.plain(part.num_frames);
    file.plain(part.from_ns);
    file.flag(part.found);
    file.raw(part.values);
    file.raw(part.sigmas);
    file.plain(part.shift_px);
}

void fields(auto& file, Is<types::RigAlignment> auto& alignment) {
    file.plain(alignment.outcome);
    file.flag(alignment.applied);
    for (auto* num : {&alignment.num_pairs,
                      &alignment.num_matches,
                      &alignment.num_inliers,
                      &alignment.num_windows})
        file.plain(*num);
    file.raw(alignment.change.values);
    file.raw(alignment.sigmas);
    for (auto* value : {&alignment.change.medium.focal_scale,
                        &alignment.change.medium.refractive_index,
                        &alignment.row_shift_px,
                        &alignment.row_error_px,
                        &alignment.pair_error_px,
                        &alignment.disparity_bias_px,
                        &alignment.disparity_bias_sigma_px,
                        &alignment.reference_depth_m})
        file.plain(*value);
    file.list(alignment.parts);
    file.plain(alignment.row_solver);
    file.plain(alignment.range_solver);
}

void fields(auto& file, Is<types::Track> auto& track) {
    fields(file, track.rig);
    file.list(track.causal);
    file.list(track.odometry);
    file.vector(track.sigmas);
    file.vector(track.motions);
    file.vector(track.breaks_ns);
    file.vector(track.features);
    file.vector(track.unusable);
    file.vector(track.rests);
    file.list(track.keyframes);
    file.list(track.mapped);
    file.list(track.landmarks);
    fields(file, track.imu_alignment);
    fields(file, track.left_out);
    file.plain(track.pressure_error_m);
    file.list(track.findings);
    file.list(track.image_findings);
    file.plain(track.statistics);
    file.plain(track.reduction);
}

void fields(auto& file, Is<types::PathPrior> auto& prior) {
    file.vector(prior.timestamps_ns);
    file.vector(prior.apart_m);
    file.matrix(prior.drift);
    file.matrix(prior.shared);
}

void fields(auto& file, Is<types::OptimisedTrack> auto& track) {
    file.list(track.trajectory);
    file.vector(track.breaks_ns);
    file.list(track.predicted);
    file.list(track.keyframes);
    file.list(track.mapped);
    file.plain(track.max_depth_m);
    fields(file, track.rig);
    fields(file, track.calibration);
    file.list(track.covariances);
    fields(file, track.prior);
    file.list(track.findings);
    file.plain(track.statistics);
}

void fields(auto& file, Is<CloudMetrics> auto& metrics) { file.plain(metrics); }

void fields(auto& file, Is<WaterColor> auto& color) {
    file.plain(color.fit.outcome);
    file.plain(color.fit.light);
    file.plain(color.fit.is_fitted);
    file.plain(color.fit.channels);
    file.plain(color.fit.explained_share);
    file.plain(color.fit.vignetting);
    file.plain(color.fit.near_m);
    file.plain(color.fit.far_m);
    file.plain(color.fit.num_points);
    file.plain(color.fit.num_sightings);
    file.vector(color.fit.log_gains);
    file.plain(color.num_lost_images);
    file.plain(color.white);
    file.vector(color.vertices);
    file.plain(color.limited_share);
}

void fields(auto& file, Is<TextureMetrics> auto& metrics) {
    file.plain(metrics.num_triangles);
    file.plain(metrics.simplification);
    file.plain(metrics.num_atlases);
    file.plain(metrics.textured_share);
    file.plain(metrics.texels_per_pixel);
    file.vector(metrics.lost_frames);
    file.plain(metrics.mosaic_pixel_m);
}

void fields(auto& file, Is<Surface> auto& surface) {
    file.vector(surface.mesh.vertices);
    file.vector(surface.mesh.normals);
    file.vector(surface.mesh.colors);
    file.vector(surface.mesh.sigma_m);
    file.vector(surface.mesh.sigma_local_m);
    file.vector(surface.mesh.num_observations);
    file.vector(surface.mesh.triangles);
    file.optional(surface.simplification);
    file.plain(surface.small_components_m2);
    file.plain(surface.cut_by_sigma_m2);
}

template <typename T>
void save(const std::filesystem::path& path, const std::string& key, const T& value) {
    base::BinaryWriter file(path);
    file.put_text(key);
    StageWriter writer{file};
    fields(writer, value);
    file.commit();
}

template <typename T>
std::optional<T> load(const std::filesystem::path& path, const std::string& key) {
    base::BinaryReader file(path);
    if (!file.ok() || file.get_text() != key || !file.ok()) return std::nullopt;
    T value;
    StageReader reader{file};
    fields(reader, value);
    if (!file.at_end()) return std::nullopt;
    return value;
}

}  // namespace

void save_rig_alignment(const std::filesystem::path& path,
                        const std::string& key,
                        const types::RigAlignment& alignment) {
    save(path, key, alignment);
}

std::optional<types::RigAlignment> load_rig_alignment(const std::filesystem::path& path,
                                                      const std::string& key) {
    return load<types::RigAlignment>(path, key);
}

void save_track(const std::filesystem::path& path,
                const std::string& key,
                const types::Track& track) {
    save(path, key, track);
}

std::optional<types::Track> load_track(const std::filesystem::path& path, const std::string& key) {
    return load<types::Track>(path, key);
}

void save_optimised_track(const std::filesystem::path& path,
                          const std::string& key,
                          const types::OptimisedTrack& track) {
    save(path, key, track);
}

std::optional<types::OptimisedTrack> load_optimised_track(const std::filesystem::path& path,
                                                          const std::string& key) {
    return load<types::OptimisedTrack>(path, key);
}

void save_cloud_metrics(const std::filesystem::path& path,
                        const std::string& key,
                        const CloudMetrics& metrics) {
    save(path, key, metrics);
}

std::optional<CloudMetrics> load_cloud_metrics(const std::filesystem::path& path,
                                               const std::string& key) {
    return load<CloudMetrics>(path, key);
}

void save_surface(const std::filesystem::path& path,
                  const std::string& key,
                  const Surface& surface) {
    save(path, key, surface);
}

std::optional<Surface> load_surface(const std::filesystem::path& path, const std::string& key) {
    return load<Surface>(path, key);
}

void save_water_color(const std::filesystem::path& path,
                      const std::string& key,
                      const WaterColor& color) {
    save(path, key, color);
}

std::optional<WaterColor> load_water_color(const std::filesystem::path& path,
                                           const std::string& key) {
    return load<WaterColor>(path, key);
}

void save_texture_metrics(const std::filesystem::path& path,
                          const std::string& key,
                          const TextureMetrics& metrics) {
    save(path, key, metrics);
}

std::optional<TextureMetrics> load_texture_metrics(const std::filesystem::path& path,
                                                   const std::string& key) {
    return load<TextureMetrics>(path, key);
}

}  // namespace divemesh::pipeline
