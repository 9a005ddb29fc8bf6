#pragma once

#include "worker/recording/calibration_parts.hpp"
#include "worker/recording/mat_file.hpp"

namespace divemesh::recording {

// Reads the struct of toStruct(stereoParams) of the Computer Vision Toolbox, as a variable of a
// file or with its fields as variables, or what the Camera Calibration Toolbox of Bouguet saves.
// Throws Error{BadData} with the reason and what to do.
CalibrationParts read_matlab_calibration(const MatValue& variables,
                                         const std::string& file,
                                         const RigHints& hints,
                                         dive::FindingLog& findings);

}  // namespace divemesh::recording
