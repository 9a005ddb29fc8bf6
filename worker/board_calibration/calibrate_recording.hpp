#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "schemas/links.hpp"
#include "worker/base/observer.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::board_calibration {

struct CalibrationRequest {
    std::filesystem::path recording;  // what recording::as_dive() and dive::open_source() open
    std::filesystem::path target;     // target file of Kalibr
    std::filesystem::path out;        // created if missing
    std::filesystem::path scratch;    // the caller removes it
    std::optional<types::Distortion> model;  // nullopt: as in calibrate_rig()
    int num_threads = 0;                     // 0: all cores; never changes a result
    Links links = Links::LeaveOut;           // in the folder `recording`
};

// Returns the lens model of a word; nullopt for "auto". Throws Error{InvalidArgument}, which lists
// the words.
std::optional<types::Distortion> model_from_string(std::string_view text);

// Calibrates a stereo rig by a board that it recorded and writes calibration.json, report.html and,
// if the rig is determined, mav0/cam0/sensor.yaml and mav0/cam1/sensor.yaml into `out`; returns the
// content of calibration.json. Throws Error{NotFound} and Error{BadData} for files that are missing
// or unreadable, Error{Conflict} if `out` has a calibration already, Error{Cancelled}.
nlohmann::json calibrate_recording(const CalibrationRequest& request,
                                   const base::ProgressCallback& progress);

}  // namespace divemesh::board_calibration
