#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/types/solver_outcome.hpp"

namespace divemesh::types {

// What changes about cameras that record in another medium than that of their calibration: rays are
// refracted at a flat port, or, where a calibration was scaled for the other medium, the focal
// lengths differ by the refractive index.
struct MediumChange {
    double focal_scale = 1.0;       // of both cameras
    double refractive_index = 1.0;  // as in Camera

    bool is_none() const { return focal_scale == 1.0 && refractive_index == 1.0; }
};

// The real pose of the right camera relative to the left one, as a change of the stated
// calibration.
struct RigChange {
    static constexpr int kPitch = 0;  // rad, rotation of the right camera about its own axes
    static constexpr int kYaw = 1;
    static constexpr int kRoll = 2;
    static constexpr int kDown = 3;  // rad, direction of the baseline in the rectified left camera
    static constexpr int kForward = 4;
    static constexpr int kFocal = 5;       // focal length of the right camera, relative
    static constexpr int kCentre = 6;      // principal point of the right camera, px to the right
    static constexpr int kCentreDown = 7;  // and px down
    static constexpr int kSize = 8;
    using Vector = Eigen::Matrix<double, kSize, 1>;

    Vector values = Vector::Zero();
    MediumChange medium;  // `values` are of cameras that are changed by it
};

// A part of a dive in which the right camera stays where it is on the rig; something moved it
// between the parts.
struct RigPart {
    std::int32_t first_frame = 0;
    std::int32_t num_frames = 0;
    std::int64_t from_ns = 0;  // timestamp of the first frame
    bool found = false;        // the images of the part determine `values`
    // Pitch, yaw, roll and focal length against the part whose camera RigAlignment describes.
    RigChange::Vector values = RigChange::Vector::Zero();
    RigChange::Vector sigmas = RigChange::Vector::Zero();  // 0: held
    double shift_px = 0.0;  // RMS over the points, of what `values` do to their rows
};

// What the images of a dive determine of the right camera's pose.
struct RigAlignment {
    enum class Outcome : std::uint8_t {
        Unknown,       // too few points were found in both images
        Inconsistent,  // the points do not fit any relative pose
        AsStated,      // the stated calibration fits
        Moved          // another pose fits better
    };

    Outcome outcome = Outcome::Unknown;
    bool applied = false;  // the dive is rectified with the change, if it is one, and the parts
    std::int32_t num_pairs = 0;
    std::int32_t num_matches = 0;
    std::int32_t num_inliers = 0;
    // As estimated; 0 where it is not significantly different from the stated value.
    RigChange change;
    RigChange::Vector sigmas = RigChange::Vector::Zero();  // 0: held at the stated value
    double row_shift_px = 0.0;   // RMS over the points, of what the change does to their rows
    double row_error_px = 0.0;   // of a point after the change: robust standard deviation
    double pair_error_px = 0.0;  // of the mean row of a pair after the change, RMS over the pairs
    // The ranges of one scene, which agree from frame to frame, determine:
    std::int32_t num_windows = 0;          // short tracks of features that were used
    double disparity_bias_px = 0.0;        // by which stated disparities are too large
    double disparity_bias_sigma_px = 0.0;  // 0: unknown
    // Empty: nothing moved the camera in mid-dive. Otherwise two or more that follow each other,
    // and all else is of one of them: the first, if the calibration nearly fits it, or the longest.
    std::vector<RigPart> parts;
    // Median depth of what the pairs behind ports show; 0: unknown, or no ports.
    double reference_depth_m = 0.0;
    SolverTally row_solver;  // of the solve whose result this is, if any
    SolverTally range_solver;

    bool moves_disparities() const {
        return sigmas[RigChange::kYaw] > 0.0 || sigmas[RigChange::kCentre] > 0.0;
    }
    // Returns how far the change moves the images, px.
    double shift_px() const {
        return std::max(row_shift_px, moves_disparities() ? std::abs(disparity_bias_px) : 0.0);
    }
};

}  // namespace divemesh::types
