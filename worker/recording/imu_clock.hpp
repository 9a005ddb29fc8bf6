#pragma once

#include "worker/dive/finding_log.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/rig_files.hpp"

namespace divemesh::recording {

// Puts the rows of the IMU that were added so far on the clock of the cameras, if the calibration
// states how they differ, and reports by how much.
void apply_imu_shift(const RigFiles& rig, DiveWriter& writer, dive::FindingLog& findings);

// Reports a difference of the clocks that is not applied, as there is no recording.
void report_unapplied_shift(const RigFiles& rig, dive::FindingLog& findings);

}  // namespace divemesh::recording
