#include "worker/pipeline/result_findings.hpp"

#include <algorithm>
#include <string>

#include "worker/base/text.hpp"
#include "worker/stats/distributions.hpp"

namespace divemesh::pipeline {
namespace {

constexpr double kMaxScaleSigma = 0.02;  // worse than any calibration that is used for surveys
constexpr std::size_t kMaxSegments = 8;  // listed one by one
// Share of the depth measured by keyframes that a mesh should have. Meshes of rendered dives have
// 0.89 to 0.97, those of buildings and streets with far backgrounds about 0.7: the rest are rims,
// and depth that no other frame confirms.
constexpr double kMinCoveredShare = 0.67;

// Share of the area of a surface without a photograph. Rendered and recorded dives have 1 to 4 %:
// rims, and sides that no keyframe sees well.
constexpr double kMaxUntextured = 0.15;
constexpr std::size_t kMaxListedFrames = 8;

// Shares of the fused depth. Cameras that look ahead over flat ground have a fifth of their image
// beyond 2.4 times its median depth, which is the reach of one voxel for all if it is chosen from
// the range. Uncertain depth is mostly measured again from nearer.
constexpr double kMaxTooFar = 0.25;
constexpr double kMaxLeftOut = 0.5;

std::string list_of(const std::vector<types::TrackingSegment>& segments) {
    std::string text;
    for (std::size_t i = 0; i < std::min(segments.size(), kMaxSegments); ++i)
        text += (i > 0 ? ", " : "") + base::fixed(segments[i].path_length_m, 2) + " m (" +
                std::to_string(segments[i].num_frames) + " frames)";
    if (segments.size() > kMaxSegments)
        text += " and " + std::to_string(segments.size() - kMaxSegments) + " more";
    return text;
}

std::string list_of(const std::vector<int>& frames) {
    std::string text;
    for (std::size_t i = 0; i < std::min(frames.size(), kMaxListedFrames); ++i) {
        text += i > 0 ? ", " : "";
        text += std::to_string(frames[i]);
    }
    if (frames.size() > kMaxListedFrames)
        text += " and " + std::to_string(frames.size() - kMaxListedFrames) + " more";
    return text;
}

// Returns why a metric was left out, in brackets; "" if it was not.
std::string reason_of(const evaluation::ExpectedAccuracy& expected, const std::string& metric) {
    for (const evaluation::LeftOut& left_out : expected.left_out)
        if (left_out.metric == metric) return " (" + left_out.reason + ")";
    return "";
}

}  // namespace

std::optional<Finding> segments_finding(const std::vector<types::TrackingSegment>& segments) {
    if (segments.size() < 2) return std::nullopt;
    return Finding{Severity::Warning,
                   "dive_in_segments",
                   "",
                   "the dive is in " + std::to_string(segments.size()) + " segments of " +
                       list_of(segments) +
                       ": their positions relative to each other are not known, so they lie side "
                       "by side along x",
                   "measure only within a segment; on the next dive keep the ground in view, and "
                   "after a pause come back to a place that was already recorded"};
}

std::optional<Finding> scale_finding(const evaluation::ExpectedAccuracy& expected) {
    if (!expected.scales.empty()) return std::nullopt;
    return Finding{
        Severity::Warning,
        "scale_untested",
        "",
        "no known distance, IMU or pressure sensor tested the scale" +
            reason_of(expected, "scale.accelerometer") +
            ": lengths are as good as the calibration of the cameras, and half a degree between "
            "them is 10 % or more",
        "lay a scale bar or two markers of known distance into the scene, or record an "
        "IMU or a depth sensor and move up and down"};
}

std::optional<Finding> scale_uncertainty_finding(const evaluation::ExpectedAccuracy& expected) {
    if (!expected.cameras || expected.cameras->sigma <= kMaxScaleSigma) return std::nullopt;
    return Finding{Severity::Warning,
                   "scale_uncertain",
                   "",
                   "all lengths are uncertain by " +
                       base::fixed(100.0 * stats::kNormal975 * expected.cameras->sigma, 0) +
                       " % (95 %): for a scene that far or that blurred, the images do not tell "
                       "whether the cameras still are where the calibration says",
                   "do not publish lengths, areas or volumes of this dive; calibrate the stereo "
                   "pair again, go nearer, or lay a scale bar into the scene"};
}

std::optional<Finding> bounds_finding(const evaluation::ExpectedAccuracy& expected,
                                      std::size_t num_segments) {
    if (expected.ate_bound_m || num_segments != 1) return std::nullopt;
    return Finding{Severity::Warning,
                   "bounds_unknown",
                   "",
                   "the error of the path has no bound: the dive had no bundle adjustment, the rig "
                   "rested throughout, or the equations could not be solved for the covariance",
                   "if another preset was used, use standard or accurate; a rig that rests has no "
                   "path to be measured; else check what else was found"};
}

std::optional<Finding> vertical_finding(bool vertical_known) {
    if (vertical_known) return std::nullopt;
    return Finding{
        Severity::Warning,
        "vertical_unknown",
        "",
        "no IMU, AHRS or pressure sensor tells which way is up, so the first image was taken to be "
        "level: the ground may lie tilted or upright in the model, and mosaic, heights and slopes "
        "with it",
        "record an IMU, an AHRS or a depth sensor on the next dive; on this one measure areas "
        "whose plane their corners give (divemesh measure --areas)"};
}

std::optional<Finding> shutter_finding(const types::RefinedCalibration& calibration) {
    if (!calibration.readout_time_applied) return std::nullopt;
    return Finding{Severity::Warning,
                   "rolling_shutter",
                   "",
                   "the cameras read the rows of an image one after the other, in " +
                       base::fixed(1e3 * std::abs(calibration.readout_time_s), 1) +
                       " ms (rolling shutter), so motion bends the images by " +
                       base::fixed(calibration.readout_shift_px, 1) +
                       " px (root mean square): path and, if made, surface are corrected for it as "
                       "far as motion "
                       "and depth are known",
                   "swim slowly and steadily, or record with cameras that have a global shutter"};
}

std::optional<Finding> left_out_finding(const fusion::FusedPixels& pixels,
                                        double max_depth_m,
                                        const VoxelSizes& voxels,
                                        const ReconstructionOptions& options) {
    const std::int64_t num_too_far = options.max_depth_m > 0.0 ? 0 : pixels.num_too_far;
    const std::int64_t num = pixels.num - pixels.num_too_far + num_too_far;
    if (num == 0) return std::nullopt;
    const double too_far = static_cast<double>(num_too_far) / static_cast<double>(num);
    const double too_vague = static_cast<double>(pixels.num_too_vague) / static_cast<double>(num);
    if (too_far <= kMaxTooFar && too_far + too_vague <= kMaxLeftOut) return std::nullopt;
    return Finding{
        Severity::Warning,
        "depth_left_out",
        "",
        base::fixed(100.0 * (too_far + too_vague), 0) +
            " % of the measured depth was too uncertain for voxels of " +
            base::fixed(1000.0 * voxels.coarsest_m, 0) +
            " mm and is missing where nothing nearer saw it: " + base::fixed(100.0 * too_far, 0) +
            " % lies beyond " + base::fixed(max_depth_m, 1) + " m, " +
            base::fixed(100.0 * too_vague, 0) + " % is nearer",
        options.voxel_m > 0.0
            ? "reconstruct again with a larger voxel_m, or without it: then the voxel grows with "
              "the distance"
            : "go nearer to what you record, with more light from the side; a larger voxel_m "
              "reaches farther, but shows less detail"};
}

std::optional<Finding> surface_finding(std::int64_t num_triangles) {
    if (num_triangles > 0) return std::nullopt;
    return Finding{Severity::Error,
                   "no_surface",
                   "",
                   "the mesh has no triangles: no depth was measured that several frames agree on",
                   "check that left and right images are equally sharp and fit the calibration "
                   "(divemesh validate DIVE), that the scene is within max_depth_m, and that "
                   "max_sigma_m does not cut away the whole surface"};
}

std::optional<Finding> incomplete_finding(const std::vector<mesh::ImageCoverage>& images,
                                          double cut_by_sigma_m2) {
    const std::optional<double> share = mesh::covered_share_of_matched(images);
    if (!share || *share >= kMinCoveredShare) return std::nullopt;
    const bool is_cut = cut_by_sigma_m2 > 0.0;
    return Finding{
        Severity::Warning,
        "surface_incomplete",
        "",
        "the mesh has only " + base::fixed(100.0 * *share, 0) + " % of the surface whose depth " +
            std::to_string(images.size()) + " keyframes measured" +
            (is_cut ? " (max_sigma_m removed " + base::fixed(cut_by_sigma_m2, 2) + " m2)" : "") +
            ": the rest is missing",
        std::string(is_cut ? "reconstruct with a larger max_sigma_m; " : "") +
            "mesh.covered_images in metrics.json names the images: swim over these places again, "
            "nearer and slower, so that several frames see each of them; measure only where there "
            "is surface"};
}

std::optional<Finding> texture_finding(const TextureMetrics& texture, std::int64_t num_keyframes) {
    const double untextured = 1.0 - texture.textured_share;
    const bool has_lost = !texture.lost_frames.empty();
    if (!has_lost && untextured <= kMaxUntextured) return std::nullopt;
    return Finding{
        Severity::Warning,
        "texture_incomplete",
        "",
        base::fixed(100.0 * untextured, 0) +
            " % of the area in mesh.glb has no photograph, but the colours of its vertices: " +
            (has_lost ? "the images of " + std::to_string(texture.lost_frames.size()) + " of " +
                            std::to_string(num_keyframes) +
                            " keyframes could not be read again (frames " +
                            list_of(texture.lost_frames) + ")"
                      : "no keyframe shows it whole, from the front and with nothing before it"),
        has_lost ? "check the disk with the dive and the one with its scratch folder (divemesh "
                   "validate DIVE reads every image), then reconstruct again"
                 : "swim over these places again so that the cameras look straight at them; the "
                   "shape in mesh.ply is not affected"};
}

}  // namespace divemesh::pipeline
