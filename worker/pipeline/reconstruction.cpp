#include "worker/pipeline/reconstruction.hpp"

#include <mutex>

#include "schemas/error.hpp"
#include "schemas/verdict.hpp"
#include "worker/base/free_memory.hpp"
#include "worker/calibration/calibration_refinement.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/pipeline/check_cameras.hpp"
#include "worker/recording/recorded_dive.hpp"

namespace divemesh::pipeline {
namespace {

// Tells the findings on the dive; throws Error{BadData} with the first error among them.
void check_dive(const dive::Dive& dive, const ReconstructionRequest& request) {
    std::vector<Finding> findings = dive.findings();
    if (!has_error(findings))
        if (const auto no_overlap = find_no_overlap(dive)) findings.push_back(*no_overlap);
    request.dive_checked(findings);
    if (const auto error = first_error(findings))
        throw Error(ErrorCode::BadData,
                    (error->where.empty() ? "" : error->where + ": ") + error->message +
                        (error->remedy.empty() ? "" : " " + error->remedy));
}

std::unique_ptr<dive::Dive> open_dive(const ReconstructionRequest& request) {
    auto dive =
        dive::Dive::open(recording::as_dive(request.dive, request.scratch, base::ignore_progress),
                         request.scratch / "dive",
                         {},
                         base::ignore_progress,
                         request.links);
    if (request.options.correct_scale == "on" &&
        !dive::marker_plan_of(dive->markers(), request.options))
        throw Error(ErrorCode::InvalidArgument,
                    "option correct_scale needs known distances, and the dive has no markers.json: "
                    "add one, or give marker_family and marker_size_m");
    // A result of another dive must not remain if this one is refused or fails. What is no dive, or
    // a wrong option, removes nothing.
    io::remove_reconstruction(request.out);
    check_dive(*dive, request);
    base::return_freed_memory();  // frees the text of the dive's tables
    return dive;
}

// Makes the rectifier with the first image: the rig may change before that.
keyframes::KeyframeStore::LeftInColor rectified_left_images(const types::Recording& dive,
                                                            int num_threads) {
    struct Made {
        std::once_flag once;
        std::optional<camera::ImageRectifier> rectifier;
    };
    return [&dive, num_threads, made = std::make_shared<Made>()](int frame_index) {
        std::call_once(made->once,
                       [&] { made->rectifier = camera::left_rectifier(dive, num_threads); });
        return made->rectifier->rectify(dive.left_in_color(frame_index, 1));
    };
}

}  // namespace

Reconstruction::Reconstruction(const ReconstructionRequest& made_for)
    : request(made_for),
      known_options(request.options),
      opened_dive(open_dive(request)),
      dive(*opened_dive),
      recording(dive),
      marker_plan(dive::marker_plan_of(dive.markers(), request.options)),
      keyframe_store(scratch("keyframes"),
                     rectified_left_images(recording, request.options.num_threads)),
      task_pool(request.options.num_threads) {
    std::filesystem::create_directories(request.out);
}

void Reconstruction::set_rig(const types::Rig& rig) {
    recording.set_rig(rig);
    keyframe_store = keyframes::KeyframeStore(
        scratch("keyframes"), rectified_left_images(recording, request.options.num_threads));
}

void Reconstruction::set_reduction(int reduction) {
    recording.set_reduction(reduction);
    keyframe_store = keyframes::KeyframeStore(
        scratch("keyframes"), rectified_left_images(recording, request.options.num_threads));
}

types::RefinedCalibration Reconstruction::refined() const {
    types::RefinedCalibration result = optimised.calibration;
    const double reduction = recording.reduction();
    for (std::size_t side = 0; side < 2; ++side)
        for (const int centre : {1, 2}) {
            result.lenses[side].values[centre] *= reduction;
            result.lens_sigmas[side][centre] *= reduction;
        }
    result.lens_shift_px *= reduction;
    result.readout_shift_px *= reduction;
    return result;
}

types::Rig Reconstruction::used_rig() const {
    const types::Rig rig = calibration::refined_rig(recording.recorded_rig(), refined());
    return scale ? scale->applied(rig) : rig;
}

std::optional<types::GeographicPosition> Reconstruction::position() const {
    if (!georeference || !georeference->position) return dive.info().position;
    types::GeographicPosition estimated = *georeference->position;
    if (!estimated.x_azimuth_deg && dive.info().position)
        estimated.x_azimuth_deg = dive.info().position->x_azimuth_deg;
    return estimated;
}

}  // namespace divemesh::pipeline
