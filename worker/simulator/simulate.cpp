#include "worker/simulator/simulate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <tbb/task_arena.h>

#include "schemas/error.hpp"
#include "worker/base/seconds.hpp"
#include "worker/io/ply.hpp"
#include "worker/simulator/camera_sensor.hpp"
#include "worker/simulator/check_options.hpp"
#include "worker/simulator/dive_files.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/fit_ports.hpp"
#include "worker/simulator/inertial_sensors.hpp"
#include "worker/simulator/lay_markers.hpp"
#include "worker/simulator/outside_sensors.hpp"
#include "worker/simulator/reference_mesh.hpp"
#include "worker/simulator/renderer.hpp"
#include "worker/simulator/stated_rig.hpp"
#include "worker/simulator/surface_change.hpp"
#include "worker/simulator/survey.hpp"

namespace divemesh::simulator {
namespace {

namespace fs = std::filesystem;

// The time of a stereo pair; a later lap reuses the images of the first.
struct Exposure {
    std::int64_t timestamp_ns = 0;
    double t_s = 0.0;
    int shown = 0;  // index of the pair whose images it uses
};

std::vector<Exposure> plan_exposures(const SimulateOptions& options, const DiverMotion& motion) {
    const auto per_pass =
        options.laps > 0
            ? static_cast<int>(std::lround(motion.duration_s() * options.rate_hz))
            : static_cast<int>(std::floor(motion.duration_s() * options.rate_hz + 1e-6)) + 1;
    const int num_pairs = per_pass * std::max(1, options.laps);
    std::vector<Exposure> exposures;
    for (int i = 0; i < num_pairs; ++i) {
        const std::int64_t since_ns = std::llround(i * 1e9 / options.rate_hz);
        exposures.push_back({kFirstFrame_ns + since_ns, base::to_s(since_ns), i % per_pass});
    }
    return exposures;
}

void write_image(const fs::path& file, const cv::Mat& image, int jpeg_quality) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(file.extension().string(), image, bytes, {cv::IMWRITE_JPEG_QUALITY, jpeg_quality});
    std::ofstream stream(file, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream)
        throw Error(ErrorCode::OutOfSpace,
                    "cannot write " + file.string() + ": free space or choose another folder");
}

DiverMotion motion_of(const SimulateOptions& options, const Survey& survey) {
    return options.laps > 0 ? DiverMotion::closed_lap(
                                  survey.path, options.length_m, options.rate_hz, survey.seed)
                            : DiverMotion::open_path(survey.path, options.length_m, survey.seed)
                                  .with_pauses(options.pauses);
}

StatedRig state_rig(const SimulateOptions& options, const types::Rig& rig) {
    StatedRig stated = draw_calibration_error(rig, options.calibration_error, options.seed);
    if (options.vertical_misalignment_px != 0.0)
        stated.rig = pitch_right_camera(stated.rig, options.vertical_misalignment_px);
    for (types::Camera* camera : {&stated.rig.cam0, &stated.rig.cam1}) {
        if (!camera->port) continue;
        camera->port->water_index = 0.0;  // dive.json states the water
        if (!options.ports->described) camera->port.reset();
    }
    return stated;
}

// One simulated dive.
class Simulation {
public:
    Simulation(const SimulateOptions& options, const base::ProgressCallback& report)
        : options_(options),
          report_(report),
          water_(options.water.value_or(options.scene == SceneKind::Tank ? WaterKind::None
                                                                         : WaterKind::Green)),
          scene_(make_scene(options.scene, options.seed, options.year, options.length_m)),
          rig_(fit_ports(draw_rig(options.width_px, options.height_px, options.seed, options.lens),
                         options)),
          stated_(state_rig(options, rig_)),
          survey_(plan_survey(options, scene_.path, water_)),
          motion_(motion_of(options, survey_)),
          exposures_(plan_exposures(options, motion_)) {
        if (options.year > 1)
            first_year_ = make_scene(options.scene, options.seed, 1, options.length_m);
        if (options.num_markers > 0) mark();
    }

    void run() {
        tell(0);
        make_folders();
        Renderer renderer(scene_, rig_, render_options(), [this] { tell(0); });
        for (std::size_t i = 0; i < exposures_.size(); ++i) {
            for (int camera = 0; camera < 2; ++camera) {
                tell(i);
                take_image(renderer, i, camera);
            }
        }
        write_sensors();
        write_outside();
        write_measurements(options_.out / "measurements.json", scene_.distances);
        if (markers_) write_markers(options_.out / "markers.json", *markers_);
        if (options_.year > 1)
            write_changes(options_.out / "change.json",
                          options_.year,
                          scene_.changes,
                          surface_changes(*first_year_, scene_));
        write_surface("reference.ply", renderer.reference_triangles());
        write_surface("scene.ply", renderer.seen_triangles());
        write_dive_info(options_.out / "dive.json", options_, water_);
        tell(exposures_.size());
    }

private:
    void write_surface(const char* file, const std::vector<bool>& seen) const {
        io::write_ply(options_.out / file, make_reference_mesh(scene_, seen, options_.seed));
    }

    // Lays the markers as on the first dive of the first year.
    void mark() {
        SimulateOptions first = options_;
        first.year = 1;
        first.survey = 1;
        first.pauses.clear();
        const Scene& ground = first_year_ ? *first_year_ : scene_;
        auto markers = lay_markers(
            options_, rig_, motion_of(first, plan_survey(first, ground.path, water_)), ground);
        if (first_year_) {
            auto unmoved = unmoved_markers(markers, options_, *first_year_, scene_);
            put_markers(markers, options_, *first_year_);
            markers = std::move(unmoved);
        }
        put_markers(markers, options_, scene_);
        markers_ = plan_of(markers, options_);
        if (options_.control_points)
            survey_markers(markers, options_.noise, options_.seed, outside_);
    }

    RenderOptions render_options() const {
        RenderOptions render{.water = survey_.water,
                             .texture_contrast = static_cast<float>(options_.texture_contrast),
                             .exact_depth = options_.truth,
                             .seed = options_.seed};
        if (water_ == WaterKind::None) return render;
        render.caustics = options_.caustics;
        const double duration_s = motion_.duration_s();
        if (options_.fish)
            render.fish = Fish::make_school(motion_,
                                            duration_s,
                                            rig_.T_imu_cam0.linear().col(2),
                                            options_.fish_density,
                                            survey_.seed);
        const double particles_per_m3 =
            options_.snow_density *
            (water_ == WaterKind::Turbid ? 400.0 : (water_ == WaterKind::Green ? 150.0 : 60.0));
        if (options_.snow)
            render.snow = std::make_shared<MarineSnow>(particles_per_m3, survey_.seed);
        return render;
    }

    fs::path camera_folder(int camera) const {
        return options_.out / "mav0" / ("cam" + std::to_string(camera));
    }

    fs::path truth_folder(int camera, const std::string& what) const {
        return options_.out / "truth" / ("cam" + std::to_string(camera)) / what;
    }

    void make_folders() const {
        for (int camera = 0; camera < 2; ++camera) {
            fs::create_directories(camera_folder(camera) / "data");
            if (options_.truth)
                for (const char* what : {"depth", "albedo", "fish", "snow"})
                    fs::create_directories(truth_folder(camera, what));
        }
    }

    std::string image_name(std::size_t exposure) const {
        return std::to_string(exposures_[exposure].timestamp_ns) + (options_.png ? ".png" : ".jpg");
    }

    void take_image(Renderer& renderer, std::size_t index, int camera) const {
        const Exposure& exposure = exposures_[index];
        const fs::path folder = camera_folder(camera) / "data";
        const auto shown = static_cast<std::size_t>(exposure.shown);
        if (shown != index) {  // copies, not links: archives with links are refused
            fs::copy_file(folder / image_name(shown), folder / image_name(index));
            return;
        }
        const Rendering rendering =
            look(renderer, camera, exposure.t_s + (camera == 1 ? right_later_s() : 0.0));
        const cv::Mat image = develop(
            rendering.radiance,
            2 * index + static_cast<std::size_t>(camera),
            exposure.t_s,
            {.exposure = survey_.water.exposure, .noise = options_.noise, .seed = survey_.seed});
        write_image(folder / image_name(index), image, options_.jpeg_quality);
        if (options_.truth) write_truth(rendering, exposure.timestamp_ns, camera);
    }

    double right_later_s() const { return 1e-3 * options_.stereo_offset_ms; }

    Rendering look(Renderer& renderer, int camera, double t_s) const {
        const Eigen::Isometry3d T_world_imu = motion_.at(t_s).T_world_imu;
        return sees_only_water(t_s) ? renderer.render_water(camera, T_world_imu, t_s)
                                    : renderer.render(camera, T_world_imu, t_s);
    }

    bool sees_only_water(double t_s) const {
        return std::any_of(
            options_.blue_water.begin(), options_.blue_water.end(), [&](const Stretch& blue) {
                const double since_s = t_s - blue.at_share * motion_.duration_s();
                return since_s >= 0.0 && since_s < blue.duration_s;
            });
    }

    void write_truth(const Rendering& rendering, std::int64_t timestamp_ns, int camera) const {
        const std::string name = std::to_string(timestamp_ns) + ".png";
        cv::Mat depth_mm;
        rendering.depth.convertTo(depth_mm, CV_16U, 1000.0);
        write_image(truth_folder(camera, "depth") / name, depth_mm, 100);
        write_image(truth_folder(camera, "albedo") / name, to_8_bit(rendering.albedo), 100);
        write_image(truth_folder(camera, "fish") / name, rendering.fish, 100);
        write_image(truth_folder(camera, "snow") / name, rendering.snow, 100);
    }

    void write_sensors() const {
        const fs::path mav0 = options_.out / "mav0";
        std::vector<ImageName> images;
        for (std::size_t i = 0; i < exposures_.size(); ++i)
            images.push_back({exposures_[i].timestamp_ns, image_name(i)});
        const types::Rig& stated = stated_.rig;
        write_camera_files(
            camera_folder(0), stated.cam0, stated.T_imu_cam0, options_.rate_hz, images);
        write_camera_files(
            camera_folder(1), stated.cam1, stated.T_imu_cam1, options_.rate_hz, images);
        if (is_misstated()) write_true_cameras();
        const double end_s = exposures_.back().t_s;
        auto records =
            simulate_imu(motion_, end_s, options_.noise ? &*rig_.imu_noise : nullptr, survey_.seed);
        write_ground_truth_files(mav0 / "state_groundtruth_estimate0", records);
        for (ImuRecord& record : records) record.sample.timestamp_ns += stated_.imu_clock_offset_ns;
        write_imu_files(mav0 / "imu0", *rig_.imu_noise, records);
        auto orientations = simulate_ahrs(motion_, end_s, options_.noise, survey_.seed);
        for (auto& sample : orientations) sample.timestamp_ns += stated_.imu_clock_offset_ns;
        write_ahrs_files(mav0 / "ahrs0", orientations);
        if (water_ != WaterKind::None)
            write_pressure_file(
                mav0 / "pressure0",
                simulate_pressure(
                    motion_, end_s, scene_.surface_z_m, options_.noise, survey_.seed));
    }

    void write_outside() {
        const double end_s = exposures_.back().t_s;
        if (options_.positions)
            outside_.sources.push_back(simulate_positions(
                motion_, end_s, *options_.positions, options_.noise, options_.seed));
        if (options_.dvl)
            simulate_velocities(motion_, end_s, options_.noise, options_.seed, outside_);
        if (outside_.empty()) return;
        write_outside_files(options_.out, outside_);
        write_place_on_earth(options_.out / "truth" / "place.json", place_on_earth(options_.seed));
    }

    bool is_misstated() const {
        return options_.calibration_error > 0.0 || options_.vertical_misalignment_px != 0.0 ||
               (options_.ports && !options_.ports->described);
    }

    void write_true_cameras() const {
        const fs::path truth = options_.out / "truth";
        write_camera_yaml(truth / "cam0", rig_.cam0, rig_.T_imu_cam0, options_.rate_hz);
        write_camera_yaml(truth / "cam1", rig_.cam1, rig_.T_imu_cam1, options_.rate_hz);
    }

    void tell(std::size_t frames_done) const {
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - started_;
        const auto done = static_cast<double>(frames_done);
        const auto all = static_cast<double>(exposures_.size());
        Progress progress{.stage = "simulate",
                          .fraction = done / all,
                          .frames_done = static_cast<std::int64_t>(frames_done),
                          .num_frames = static_cast<std::int64_t>(exposures_.size())};
        if (frames_done > 0) {
            progress.frames_per_s = done / elapsed.count();
            progress.seconds_left = (all - done) / progress.frames_per_s;
        }
        report_(progress);
    }

    const SimulateOptions& options_;
    const base::ProgressCallback& report_;
    WaterKind water_;
    Scene scene_;
    std::optional<Scene> first_year_;  // if the scene is of a later year
    types::Rig rig_;
    StatedRig stated_;
    Survey survey_;
    DiverMotion motion_;
    std::vector<Exposure> exposures_;
    std::optional<dive::MarkerPlan> markers_;
    types::OutsidePositions outside_;
    std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
};

}  // namespace

void simulate(const SimulateOptions& options, const base::ProgressCallback& report) {
    check_options(options);
    tbb::task_arena arena(options.num_threads > 0 ? options.num_threads
                                                  : tbb::task_arena::automatic);
    arena.execute([&] { Simulation(options, report).run(); });
}

}  // namespace divemesh::simulator
