#include "worker/simulator/dive_files.hpp"

#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "worker/base/atomic_file.hpp"
#include "worker/dive/lens_yaml.hpp"
#include "worker/dive/sensor_yaml_text.hpp"
#include "worker/simulator/fit_ports.hpp"

namespace divemesh::simulator {
namespace {

constexpr int kRowDigits = 12;

void write_text(const std::filesystem::path& file, const std::string& content) {
    std::filesystem::create_directories(file.parent_path());
    base::write_file(file, content);
}

void put(std::ostream& out, const Eigen::Vector3d& v) {
    out << ',' << v.x() << ',' << v.y() << ',' << v.z();
}

void put(std::ostream& out, const Eigen::Quaterniond& q) {
    out << ',' << q.w() << ',' << q.x() << ',' << q.y() << ',' << q.z();
}

nlohmann::json to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json to_json_box(const Eigen::AlignedBox3f& box) {
    if (box.isEmpty()) return nullptr;
    return {{"min", to_array(box.min().cast<double>())},
            {"max", to_array(box.max().cast<double>())}};
}

nlohmann::json to_json(const std::vector<SurfaceChange>& surface) {
    nlohmann::json patches = nlohmann::json::array();
    double grown_m3 = 0.0;
    double lost_m3 = 0.0;
    for (const SurfaceChange& patch : surface) {
        (patch.grown ? grown_m3 : lost_m3) += patch.volume_m3;
        patches.push_back({{"names", patch.names},
                           {"kind", patch.grown ? "grown" : "lost"},
                           {"area_m2", patch.area_m2},
                           {"volume_m3", patch.volume_m3},
                           {"min", {patch.box_world.min().x(), patch.box_world.min().y()}},
                           {"max", {patch.box_world.max().x(), patch.box_world.max().y()}}});
    }
    return {{"meaning", "between the surfaces of both years as seen from above"},
            {"cell_m", kSurfaceChangeCell_m},
            {"grown_m3", grown_m3},
            {"lost_m3", lost_m3},
            {"patches", patches}};
}

}  // namespace

void write_camera_yaml(const std::filesystem::path& folder,
                       const types::Camera& camera,
                       const Eigen::Isometry3d& T_imu_cam,
                       double rate_hz) {
    dive::SensorYaml yaml;
    yaml.T_body_sensor = T_imu_cam.matrix();
    yaml.resolution = {static_cast<double>(camera.width_px), static_cast<double>(camera.height_px)};
    dive::state_lens(camera, yaml);
    if (camera.port) yaml.port = dive::state_port(*camera.port);
    write_text(folder / "sensor.yaml",
               dive::camera_yaml_text(yaml, {"rendered, global shutter", rate_hz, kRowDigits}));
}

void write_camera_files(const std::filesystem::path& folder,
                        const types::Camera& camera,
                        const Eigen::Isometry3d& T_imu_cam,
                        double rate_hz,
                        const std::vector<ImageName>& images) {
    std::ostringstream rows;
    rows << "#timestamp [ns],filename\n";
    for (const ImageName& image : images) rows << image.timestamp_ns << ',' << image.file << '\n';
    write_text(folder / "data.csv", rows.str());
    write_camera_yaml(folder, camera, T_imu_cam, rate_hz);
}

void write_imu_files(const std::filesystem::path& folder,
                     const types::ImuNoise& noise,
                     const std::vector<ImuRecord>& records) {
    std::ostringstream rows;
    rows << std::setprecision(kRowDigits)
         << "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
            "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
    for (const ImuRecord& record : records) {
        rows << record.sample.timestamp_ns;
        put(rows, record.sample.angular_velocity_imu);
        put(rows, record.sample.acceleration_imu);
        rows << '\n';
    }
    write_text(folder / "data.csv", rows.str());
    dive::SensorYaml yaml;
    yaml.gyroscope_noise_density = noise.gyroscope_noise_density;
    yaml.gyroscope_random_walk = noise.gyroscope_random_walk;
    yaml.accelerometer_noise_density = noise.accelerometer_noise_density;
    yaml.accelerometer_random_walk = noise.accelerometer_random_walk;
    write_text(folder / "sensor.yaml",
               dive::imu_yaml_text(yaml, {"simulated", kImuRateHz, kRowDigits}));
}

void write_ground_truth_files(const std::filesystem::path& folder,
                              const std::vector<ImuRecord>& records) {
    std::ostringstream rows;
    rows
        << std::setprecision(kRowDigits)
        << "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
           "q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], "
           "b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], "
           "b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n";
    for (const ImuRecord& record : records) {
        rows << record.sample.timestamp_ns;
        put(rows, Eigen::Vector3d(record.truth.T_world_imu.translation()));
        put(rows, Eigen::Quaterniond(record.truth.T_world_imu.linear()));
        put(rows, record.truth.velocity_world);
        put(rows, record.gyroscope_bias);
        put(rows, record.accelerometer_bias);
        rows << '\n';
    }
    write_text(folder / "data.csv", rows.str());
    write_text(
        folder / "sensor.yaml",
        dive::sensor_yaml_text("visual-inertial", {}, {"exact motion of the body, world z up"}));
}

void write_ahrs_files(const std::filesystem::path& folder,
                      const std::vector<types::OrientationSample>& samples) {
    std::ostringstream rows;
    rows << std::setprecision(kRowDigits)
         << "#timestamp [ns],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n";
    for (const types::OrientationSample& sample : samples) {
        rows << sample.timestamp_ns;
        put(rows, sample.q_world_imu);
        rows << '\n';
    }
    write_text(folder / "data.csv", rows.str());
    const std::string yaml = dive::sensor_yaml_text(
        "ahrs", {}, {"absolute orientation of the body in the world", kAhrsRateHz});
    write_text(
        folder / "sensor.yaml",
        yaml + "orientation_error_rms_deg: 0.5   # at most; slowly varying, 0.02 deg white\n");
}

void write_pressure_file(const std::filesystem::path& folder,
                         const std::vector<types::PressureSample>& samples) {
    std::ostringstream rows;
    rows << std::setprecision(kRowDigits) << "#timestamp [ns],depth [m]\n";
    for (const types::PressureSample& sample : samples)
        rows << sample.timestamp_ns << ',' << sample.depth_m << '\n';
    write_text(folder / "data.csv", rows.str());
}

void write_outside_files(const std::filesystem::path& dive,
                         const types::OutsidePositions& outside) {
    for (const types::PositionSource& source : outside.sources) {
        std::ostringstream rows;
        rows << std::fixed << std::setprecision(4)
             << "#timestamp [ns],easting [m],northing [m],up [m],sigma_h [m],sigma_v [m]\n";
        for (const types::PositionSample& sample : source.samples) {
            rows << sample.timestamp_ns;
            put(rows, sample.utm_m);
            rows << ',' << sample.sigma_h_m << ',' << sample.sigma_v_m << '\n';
        }
        const std::filesystem::path folder = dive / "mav0" / source.name;
        write_text(folder / "data.csv", rows.str());
        write_text(folder / "sensor.yaml",
                   dive::sensor_yaml_text("position", {}, {"position of the body"}) + "kind: " +
                       std::string(enum_to_text(types::kPositionKindTexts, source.kind)) +
                       "\nepsg: " + std::to_string(source.epsg) + "\n");
    }
    if (!outside.velocities.empty()) {
        std::ostringstream rows;
        rows << std::setprecision(kRowDigits)
             << "#timestamp [ns],v_x [m/s],v_y [m/s],v_z [m/s],sigma [m/s]\n";
        for (const types::VelocitySample& sample : outside.velocities) {
            rows << sample.timestamp_ns;
            put(rows, sample.velocity_instrument);
            rows << ',' << sample.sigma_m_s << '\n';
        }
        const std::filesystem::path folder = dive / "mav0" / "velocity0";
        write_text(folder / "data.csv", rows.str());
        write_text(folder / "sensor.yaml",
                   dive::sensor_yaml_text(
                       "velocity", {.T_body_sensor = outside.T_imu_dvl.matrix()}, {"DVL"}));
    }
    if (outside.control_points.empty()) return;
    nlohmann::json points = nlohmann::json::array();
    for (const types::ControlPoint& point : outside.control_points)
        points.push_back({{"name", point.name},
                          {"marker_id", point.marker_id},
                          {"position", to_array(point.utm_m)},
                          {"sigma_h_m", point.sigma_h_m},
                          {"sigma_v_m", point.sigma_v_m}});
    const nlohmann::json all = {{"epsg", outside.control_points_epsg}, {"points", points}};
    write_text(dive / "control_points.json", all.dump(1) + "\n");
}

void write_place_on_earth(const std::filesystem::path& file,
                          const types::GeographicPosition& position) {
    const nlohmann::json all = {{"frame", "origin and x axis of state_groundtruth_estimate0"},
                                {"latitude_deg", position.latitude_deg},
                                {"longitude_deg", position.longitude_deg},
                                {"x_azimuth_deg", position.x_azimuth_deg.value_or(0.0)}};
    write_text(file, all.dump(1) + "\n");
}

void write_dive_info(const std::filesystem::path& file,
                     const SimulateOptions& options,
                     WaterKind water) {
    const std::string scene(to_string(options.scene));
    nlohmann::json info = {
        {"name", scene + ", seed " + std::to_string(options.seed)},
        {"site", "simulated " + scene},
        {"rig", "simulated stereo rig " + std::to_string(options.seed)},
        {"notes",
         "rendered with exact ground truth; water: " + std::string(to_string(water)) + "; year " +
             std::to_string(options.year) +
             (options.survey > 1 ? ", survey " + std::to_string(options.survey) : "")},
        {"tags", {"simulated", scene, std::string(to_string(water))}}};
    if (water != WaterKind::None)
        info["water"] = {{"temperature_c", kWater_c}, {"salinity_psu", options.salinity_psu}};
    write_text(file, info.dump(1) + "\n");
}

void write_measurements(const std::filesystem::path& file,
                        const std::vector<SceneDistance>& distances) {
    nlohmann::json list = nlohmann::json::array();
    for (const SceneDistance& entry : distances)
        list.push_back({{"name", entry.distance.name},
                        {"what", entry.what},
                        {"a", to_array(entry.distance.a_world)},
                        {"b", to_array(entry.distance.b_world)},
                        {"distance_m", entry.distance.distance_m}});
    const nlohmann::json all = {{"units", "m"},
                                {"frame", "world of state_groundtruth_estimate0 (z up)"},
                                {"distances", list}};
    write_text(file, all.dump(1) + "\n");
}

void write_markers(const std::filesystem::path& file, const dive::MarkerPlan& plan) {
    write_text(file, to_json(plan).dump(1) + "\n");
}

void write_changes(const std::filesystem::path& file,
                   int year,
                   const std::vector<SceneChange>& changes,
                   const std::vector<SurfaceChange>& surface) {
    nlohmann::json list = nlohmann::json::array();
    for (const SceneChange& change : changes)
        list.push_back({{"name", change.name},
                        {"kind", change.kind},
                        {"before", to_json_box(change.before_world)},
                        {"after", to_json_box(change.after_world)},
                        {"volume_before_m3", change.volume_before_m3},
                        {"volume_after_m3", change.volume_after_m3}});
    const nlohmann::json all = {{"units", "m"},
                                {"frame", "world of state_groundtruth_estimate0 (z up)"},
                                {"from_year", 1},
                                {"to_year", year},
                                {"changes", list},
                                {"surface", to_json(surface)}};
    write_text(file, all.dump(1) + "\n");
}

}  // namespace divemesh::simulator
