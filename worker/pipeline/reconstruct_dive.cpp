#include "worker/pipeline/reconstruct_dive.hpp"

#include <opencv2/core/utility.hpp>

#include "worker/base/atomic_file.hpp"
#include "worker/base/free_memory.hpp"
#include "worker/io/certificate.hpp"
#include "worker/io/exports.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/pipeline/build_id.hpp"
#include "worker/pipeline/reconstruction_metrics.hpp"
#include "worker/pipeline/reconstruction_stages.hpp"
#include "worker/pipeline/run_stages.hpp"
#include "worker/pipeline/stage_cache.hpp"
#include "worker/report/report.hpp"

namespace divemesh::pipeline {
namespace {

void write_exports(const Reconstruction& made) {
    auto formats = io::export_formats(made.options().exports);
    const io::ReconstructionFolder folder(made.request.out);
    const auto position = io::position_of(folder);
    if (position && made.options().surface && made.options().texture)
        formats.push_back(io::ExportFormat::Geotiff);
    io::export_reconstruction(
        folder, formats, position, made.request.out, [&made](int frame_index) {
            return made.keyframe_store.left_in_color(frame_index);
        });
}

// Writes metrics.json, its certificate and the report; returns the content of metrics.json.
nlohmann::json write_documents(const Reconstruction& made) {
    auto document = metrics_of(made);
    base::write_file(made.artifact("metrics.json"), document.dump(2) + "\n");
    base::write_file(made.artifact("certificate.json"),
                     io::certificate_of(document).dump(2) + "\n");
    base::write_file(made.artifact("report.html"),
                     report::report_html({.metrics = document,
                                          .trajectory = made.optimised.trajectory,
                                          .evaluation = made.evaluation,
                                          .image_png = made.thumbnail_png}));
    if (!made.has_failed()) write_exports(made);
    return document;
}

}  // namespace

nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const std::vector<Stage<Reconstruction>>& stages,
                                StageStore& store,
                                const base::ProgressCallback& progress) {
    // OpenCV's pool waits actively, which costs more than it saves with images of this size.
    cv::setNumThreads(1);
    StageProgress stage_progress(progress);
    Reconstruction made(request);
    const auto done = [&](const StageSpec& stage, const StageTime& time) {
        made.stages.push_back(time);
        if (stage.part_of.empty()) request.stage_done({time.stage, time.wall_s, time.reused});
        base::return_freed_memory();
    };
    const std::vector<StageSpec> specs = specs_of(stages);
    run_stages(
        stages,
        made,
        {.keys = stage_keys(
             specs, DIVEMESH_VERSION + build_id(), made.dive.content_sha256(), request.options),
         .scratch = request.scratch,
         .resumable = request.resumable,
         .store = store,
         .progress = stage_progress,
         .begin =
             [&](std::size_t index) {
                 made.known_options = options_known_to(index, specs, request.options);
             },
         .done = done});
    made.known_options = request.options;
    auto document = write_documents(made);
    stage_progress.finish();
    return document;
}

nlohmann::json reconstruct_dive(const ReconstructionRequest& request,
                                const base::ProgressCallback& progress) {
    StageCache store(request.cache, request.cache_bytes);
    return reconstruct_dive(request, reconstruction_stages(), store, progress);
}

}  // namespace divemesh::pipeline
