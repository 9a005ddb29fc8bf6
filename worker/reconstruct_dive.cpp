#include "worker/reconstruct_dive.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <vector>

#include "schemas/error.hpp"
#include "worker/background.hpp"
#include "worker/build_id.hpp"
#include "worker/dive/dive.hpp"
#include "worker/estimation/path_uncertainty.hpp"
#include "worker/free_memory.hpp"
#include "worker/geometry/rectifier.hpp"
#include "worker/keyframe_store.hpp"
#include "worker/markers/measure_bars.hpp"
#include "worker/markers/survey_markers.hpp"
#include "worker/markers/world_scale.hpp"
#include "worker/metrics/evaluation.hpp"
#include "worker/metrics/simplification_error.hpp"
#include "worker/mosaic/keyframe_pictures.hpp"
#include "worker/mosaic/mosaic.hpp"
#include "worker/output/atomic_file.hpp"
#include "worker/output/covariance_file.hpp"
#include "worker/output/exports.hpp"
#include "worker/output/glb_writer.hpp"
#include "worker/output/ply.hpp"
#include "worker/output/reconstruction_folder.hpp"
#include "worker/output/trajectory_file.hpp"
#include "worker/reconstruct.hpp"
#include "worker/reconstruction_figures.hpp"
#include "worker/report/report.hpp"
#include "worker/stage_cache.hpp"
#include "worker/stage_files.hpp"
#include "worker/stage_keys.hpp"
#include "worker/stage_progress.hpp"
#include "worker/volume/confirmed_points.hpp"
#include "worker/volume/mesh_borders.hpp"
#include "worker/volume/simplify_mesh.hpp"
#include "worker/volume/vertex_sigma.hpp"

namespace divemesh::worker {
namespace {

std::unique_ptr<Dive> open_dive(const ReconstructionRequest& request) {
    auto dive = Dive::open(request.dive, request.scratch / "dive");
    for (const Finding& finding : dive->findings())
        if (finding.severity == Severity::Error)
            throw Error(ErrorCode::BadData,
                        (finding.where.empty() ? "" : finding.where + ": ") + finding.message +
                            (finding.remedy.empty() ? "" : " " + finding.remedy));
    if (request.options.correct_scale && !marker_plan_of(dive->markers(), request.options))
        throw Error(ErrorCode::InvalidArgument,
                    "option correct_scale has nothing to correct by: the dive has no markers.json, "
                    "and marker_family and marker_size_m are not given");
    return_freed_memory();  // the texts of its tables
    return dive;
}

std::string read_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

KeyframeStore::LeftInColor rectified_pictures(const Dive& dive) {
    return [&dive, rectifier = std::make_shared<const Rectifier>(dive.rig())](int frame_index) {
        return rectifier->rectify_left(dive.left_in_color(frame_index));
    };
}

constexpr double kShareWithoutSurface = 0.72;  // of track, optimise and evaluate

Surface simplified(Mesh mesh, const ReconstructionOptions& options) {
    if (options.simplify >= 1.0 || mesh.triangles.empty()) return {std::move(mesh), std::nullopt};
    Mesh fewer = simplify_mesh(mesh, {options.simplify, options.simplify_error_m});
    const auto error = simplification_error(mesh, fewer, options.num_threads);
    return {std::move(fewer), error};
}

// One run of the stages over one dive: what they hand on, in memory and in the scratch folder.
class DiveRun {
public:
    DiveRun(const ReconstructionRequest& request, const ProgressCallback& progress)
        : request_(request),
          stages_(progress),
          dive_(open_dive(request)),
          keys_(
              stage_keys(DIVEMESH_VERSION + build_id(), dive_->content_sha256(), request.options)),
          cache_(request.cache, request.cache_bytes),
          keyframe_store_(request.scratch / "keyframes", rectified_pictures(*dive_)),
          workers_(request.options.num_threads) {
        std::filesystem::create_directories(request.out);
    }

    nlohmann::json run() {
        track();
        optimise();
        measure_markers();
        if (request_.options.surface) make_surface();
        return evaluate();
    }

private:
    void track();
    void optimise();
    void measure_markers();
    void correct_scale(const std::vector<TagView>& views, const MarkerPlan& plan);
    void make_surface() {
        fuse();
        mesh();
        texture();
    }
    void fuse();
    void write_cloud(const std::filesystem::path& file, std::shared_ptr<const OctreeVolume> cloud);
    void mesh();
    void texture();
    void write_pictures(const std::filesystem::path& folder,
                        const std::filesystem::path& picture,
                        const ProgressCallback& progress) const;
    nlohmann::json evaluate();
    void write_exports() const;
    Reconstruction reconstruction() const;
    MarkerWorld marker_world() const {
        return {
            optimised_.rig, optimised_.keyframes, optimised_.trajectory, optimised_.covariances};
    }

    // `share` of the whole when a surface is made; without one the other stages are all there is.
    ProgressCallback begin(const std::string& stage, double share) {
        return stages_.begin(stage,
                             request_.options.surface ? share : share / kShareWithoutSurface);
    }
    std::filesystem::path stage_file(const std::string& name) const {
        return request_.scratch / (name + ".stage");
    }
    std::string volume_name() const { return "volume-" + keys_.fuse.substr(0, 16); }
    // What an attempt before this one left, or the cache has; `load` reads it from the scratch
    // folder.
    template <typename Load>
    auto found(const std::string& entry, const Load& load) {
        auto stored = load();
        if (!stored && cache_.fetch(entry, request_.scratch)) {
            stored = load();
            if (!stored) cache_.drop(entry);
        }
        return stored;
    }
    // `save` writes the files `names` of the entry into the scratch folder, but for those that the
    // stage itself has left there.
    template <typename Save>
    void keep(const std::string& entry, const std::vector<std::string>& names, const Save& save) {
        if (!request_.resumable) return;
        save();
        cache_.store(entry, request_.scratch, names);
    }
    void stage_done(const Stopwatch& watch, const std::string& stage, bool reused) {
        stage_times_.push_back(watch.stop(stage));
        stage_times_.back().reused = reused;
        request_.stage_done({stage, stage_times_.back().wall_s, reused});
        return_freed_memory();
    }

    const ReconstructionRequest& request_;
    StageProgress stages_;
    std::unique_ptr<Dive> dive_;
    StageKeys keys_;
    StageCache cache_;
    KeyframeStore keyframe_store_;
    Track track_;  // of what only optimise() reads, nothing after it
    std::int64_t num_landmarks_ = 0;
    OptimisedTrack optimised_;
    std::unique_ptr<Volume> volume_;        // until the mesh is made of it
    std::optional<MarkerFigures> markers_;  // nothing: nobody asked for them
    std::optional<WorldScale> scale_;       // that was applied
    double voxel_m_ = 0.0;
    std::int64_t volume_memory_bytes_ = 0;
    Surface surface_;
    CloudFigures cloud_;
    MeshBorders borders_;
    std::string picture_png_;
    std::vector<StageTime> stage_times_;
    // Of the cloud while the mesh is made, of the mesh while its pictures are; they end before what
    // they read goes.
    Workers workers_;
    Background cloud_writer_{workers_};
    Background ply_writer_{workers_};
    Background border_finder_{workers_};
};

void DiveRun::track() {
    const Stopwatch watch;
    const auto progress = begin("track", 0.55);
    const std::string entry = "track-" + keys_.track;
    auto stored = found(entry, [&] { return load_track(stage_file("track"), keys_.track); });
    const bool reused = stored.has_value();
    if (!stored) {
        keyframe_store_.clear();  // what lies there may be a link into the cache
        stored = worker::track(*dive_, request_.options, keyframe_store_, progress);
        keep(entry, {"track.stage", "keyframes"}, [&] {
            save_track(stage_file("track"), keys_.track, *stored);
        });
    }
    track_ = std::move(*stored);
    write_tum(request_.out / "trajectory_causal.tum", track_.causal);
    stage_done(watch, "track", reused);
}

void DiveRun::optimise() {
    const Stopwatch watch;
    const auto progress = begin("optimise", 0.1);
    const std::string entry = "optimise-" + keys_.optimise;
    auto stored =
        found(entry, [&] { return load_optimised_track(stage_file("optimise"), keys_.optimise); });
    const bool reused = stored.has_value();
    if (!stored) {
        stored = worker::optimise(track_, *dive_, request_.options, keyframe_store_, progress);
        keep(entry, {"optimise.stage"}, [&] {
            save_optimised_track(stage_file("optimise"), keys_.optimise, *stored);
        });
    }
    optimised_ = std::move(*stored);
    if (request_.options.surface && optimised_.calibration.lenses_applied)
        keyframe_store_ = keyframe_store_.rerectified(std::make_shared<KeyframeRerectifier>(
            track_.rig,
            Rerectifier(dive_->rig(), track_.rig, optimised_.calibration.applied_lenses)));
    write_tum(request_.out / "trajectory.tum", optimised_.trajectory);
    write_covariances(request_.out / "trajectory_covariance.csv", optimised_.covariances);
    // An hour's dive needs the room for what follows.
    num_landmarks_ = std::ssize(track_.landmarks);
    track_.landmarks = {};
    track_.odometry = {};
    stage_done(watch, "optimise", reused);
}

void DiveRun::measure_markers() {
    const auto plan = marker_plan_of(dive_->markers(), request_.options);
    if (!plan) return;
    const Stopwatch watch;
    const ProgressShare progress{"optimise", 0.0, 1.0, begin("optimise", 0.0)};
    std::optional<Rerectifier> refined;
    if (optimised_.calibration.lenses_applied)
        refined.emplace(dive_->rig(), track_.rig, optimised_.calibration.applied_lenses);
    const auto views = find_tags_in(*dive_,
                                    optimised_.keyframes,
                                    plan->family,
                                    refined ? &*refined : nullptr,
                                    progress,
                                    request_.options.num_threads);
    markers_ = worker::measure_markers(views, *plan, marker_world());
    if (request_.options.correct_scale) correct_scale(views, *plan);
    stage_times_.push_back(watch.stop("markers"));
}

// Before anything is made of the poses, so that all that is given out has the one scale.
void DiveRun::correct_scale(const std::vector<TagView>& views, const MarkerPlan& plan) {
    ScaleCorrection correction;
    if (const auto reason = reason_against(markers_->scale)) {
        markers_->findings.push_back(*reason);
    } else {
        correction = {true, *markers_->scale};
        const double factor = correction.scale.factor;
        scale_.emplace(factor, optimised_.rig.T_imu_cam);
        optimised_.keyframes = scale_->applied(optimised_.keyframes, optimised_.trajectory);
        optimised_.mapped = scale_->applied(optimised_.mapped, optimised_.trajectory);
        optimised_.trajectory = scale_->applied(optimised_.trajectory);
        optimised_.covariances = scale_->applied(optimised_.covariances);
        optimised_.rig.baseline_m *= factor;
        track_.causal = WorldScale(factor, track_.rig.T_imu_cam).applied(track_.causal);
        track_.statistics.median_depth_m *= factor;
        write_tum(request_.out / "trajectory_causal.tum", track_.causal);
        write_tum(request_.out / "trajectory.tum", optimised_.trajectory);
        write_covariances(request_.out / "trajectory_covariance.csv", optimised_.covariances);
        markers_ = worker::measure_markers(views, plan, marker_world());
    }
    markers_->correction = std::move(correction);
}

void DiveRun::fuse() {
    const Stopwatch watch;
    const auto progress = begin("fuse", 0.15);
    const std::string entry = "fuse-" + keys_.fuse;
    const auto volume_file = stage_file(volume_name());
    const auto cloud_file = request_.scratch / "cloud.ply";
    const auto cloud_artifact = request_.out / "cloud.ply";
    const auto figures = found(entry, [&] {
        auto stored = load_cloud_figures(stage_file("cloud"), keys_.fuse);
        if (!std::filesystem::exists(cloud_file) || !std::filesystem::exists(volume_file))
            stored.reset();
        return stored;
    });
    const bool reused = figures.has_value();
    if (reused) {
        cloud_ = *figures;
        link_or_copy(cloud_file, cloud_artifact);
        volume_ =
            load_volume(volume_file, {request_.scratch, request_.options.fusion_memory_bytes});
    } else {
        FusedMap map = worker::fuse(optimised_.rig,
                                    optimised_.mapped,
                                    track_.statistics.median_depth_m,
                                    request_.options,
                                    keyframe_store_,
                                    request_.scratch,
                                    progress);
        volume_ = std::move(map.volume);
        write_cloud(cloud_artifact, std::move(map.cloud));
        keep(entry, {volume_name() + ".stage", "cloud.stage", "cloud.ply"}, [&] {
            cloud_writer_.wait();
            volume_->save(volume_file);
            link_or_copy(cloud_artifact, cloud_file);
            save_cloud_figures(stage_file("cloud"), keys_.fuse, cloud_);
        });
    }
    voxel_m_ = volume_->voxel_m();
    volume_memory_bytes_ = volume_->memory_bytes();
    stage_done(watch, "fuse", reused);
}

// Beside the meshing: what is asked of the volume is asked before.
void DiveRun::write_cloud(const std::filesystem::path& file,
                          std::shared_ptr<const OctreeVolume> cloud) {
    const PointOctree& octree = cloud->octree();
    const auto points =
        std::make_shared<const ConfirmedPoints>(octree, *volume_, request_.options.num_threads);
    cloud_ = {points->size(), octree.leaf_m(), octree.num_points(), octree.size_bytes()};
    cloud_writer_.run([file, cloud = std::move(cloud), points] {
        CloudPlyWriter writer(file, points->size());
        points->for_each([&](const Eigen::Vector3f& p_world, const Color& color) {
            writer.add(p_world, color);
        });
        writer.commit();
    });
    if (request_.options.num_threads == 1) cloud_writer_.wait();  // nobody else: room for the mesh
}

void DiveRun::mesh() {
    const Stopwatch watch;
    const auto progress = begin("mesh", 0.08);
    const std::string entry = "mesh-" + keys_.mesh;
    auto stored = found(entry, [&] { return load_surface(stage_file("mesh"), keys_.mesh); });
    const bool reused = stored.has_value();
    if (!stored) {
        Mesh mesh = worker::mesh(*volume_, request_.options, progress);
        finish_sigma(mesh, voxel_m_, shared_sigma_m(optimised_.statistics.path));
        stored = simplified(std::move(mesh), request_.options);
        keep(entry, {"mesh.stage"}, [&] { save_surface(stage_file("mesh"), keys_.mesh, *stored); });
    }
    cloud_writer_.wait();
    volume_.reset();
    surface_ = std::move(*stored);
    ply_writer_.run([this] { write_ply(request_.out / "mesh.ply", surface_.mesh); });
    border_finder_.run([this] { borders_ = find_borders(surface_.mesh); });
    stage_done(watch, "mesh", reused);
}

void DiveRun::texture() {
    const Stopwatch watch;
    const auto progress = begin("texture", 0.05);
    const std::string entry = "texture-" + keys_.texture;
    const auto folder = request_.scratch / entry;
    const auto picture = folder / "thumbnail.png";
    const bool reused = cache_.fetch(entry, request_.scratch);
    if (!reused) {
        std::filesystem::create_directories(folder);
        write_pictures(folder, picture, progress);
        keep(entry, {entry}, [] {});
    }
    if (std::filesystem::exists(picture)) picture_png_ = read_text(picture);
    for (const auto& made : std::filesystem::recursive_directory_iterator(folder))
        if (made.is_regular_file() && made.path() != picture)
            link_or_copy(made.path(), request_.out / made.path().lexically_relative(folder));
    ply_writer_.wait();
    border_finder_.wait();
    stage_done(watch, "texture", reused);
}

void DiveRun::write_pictures(const std::filesystem::path& folder,
                             const std::filesystem::path& picture,
                             const ProgressCallback& progress) const {
    write_glb(folder / "mesh.glb", surface_.mesh);
    progress({});
    write_keyframe_pictures(folder,
                            optimised_.rig,
                            optimised_.keyframes,
                            keyframe_store_,
                            request_.options.num_threads,
                            progress);
    if (!request_.options.texture) return;
    const Mosaic mosaic = render_mosaic(surface_.mesh);
    write_mosaic(folder, mosaic);
    write_file(picture, thumbnail_png(mosaic));
}

nlohmann::json DiveRun::evaluate() {
    const Stopwatch watch;
    begin("evaluate", 0.07);
    const Evaluation evaluation = compare_with_truth(reconstruction());
    stage_done(watch, "evaluate", false);

    auto document = metrics_of(reconstruction(), evaluation);
    write_file(request_.out / "metrics.json", document.dump(2) + "\n");
    write_file(request_.out / "report.html",
               report_html({.metrics = document,
                            .trajectory = optimised_.trajectory,
                            .evaluation = evaluation,
                            .picture_png = picture_png_}));
    write_exports();
    stages_.finish();
    return document;
}

void DiveRun::write_exports() const {
    auto formats = export_formats(request_.options.exports);
    const ReconstructionFolder made(request_.out);
    const auto position = position_of(made);
    if (position && request_.options.surface && request_.options.texture)
        formats.push_back(ExportFormat::Geotiff);
    export_reconstruction(made, formats, position, request_.out);
}

Reconstruction DiveRun::reconstruction() const {
    return {.request = request_,
            .dive = *dive_,
            .track = track_,
            .num_landmarks = num_landmarks_,
            .optimised = optimised_,
            .surface = surface_,
            .borders = borders_,
            .cloud = cloud_,
            .voxel_m = voxel_m_,
            .volume_memory_bytes = volume_memory_bytes_,
            .scale = scale_,
            .markers = markers_,
            .stages = stage_times_};
}

}  // namespace

nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const ProgressCallback& progress) {
    // Its pool waits actively: more work than it takes off us with pictures of this size.
    cv::setNumThreads(1);
    return DiveRun(request, progress).run();
}

}  // namespace divemesh::worker
