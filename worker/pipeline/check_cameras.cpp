#include "worker/pipeline/check_cameras.hpp"

#include "schemas/error.hpp"
#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/text.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/pipeline/align_cameras.hpp"
#include "worker/pipeline/alignment_findings.hpp"

namespace divemesh::pipeline {
namespace {

Finding no_overlap_finding(const types::Rig& rig) {
    const double angle_deg = base::kDegPerRad * base::angle_rad(rig.T_cam1_cam0().linear());
    return {Severity::Error,
            "calibration_no_overlap",
            "mav0/cam1/sensor.yaml",
            "the fields of view of the two cameras hardly overlap: by T_BS, cam1 is turned by " +
                base::fixed(angle_deg, 1) + " degrees against cam0",
            "Check T_BS and intrinsics of cam0 and cam1, or mount the cameras so that both see the "
            "same scene and calibrate them again."};
}

}  // namespace

std::optional<Finding> find_no_overlap(const types::Recording& recording) try {
    camera::rectified_rig(recording.rig(), recording.fixed_pattern());
    return std::nullopt;
} catch (const Error& error) {
    if (error.code() != ErrorCode::BadData) throw;
    return no_overlap_finding(recording.rig());
}

std::vector<Finding> check_cameras(const types::Recording& recording,
                                   const base::ProgressCallback& progress) try {
    return alignment_findings(align_cameras(recording, 0, progress));
} catch (const Error& error) {
    if (error.code() != ErrorCode::BadData) throw;
    return {no_overlap_finding(recording.rig())};
}

}  // namespace divemesh::pipeline
