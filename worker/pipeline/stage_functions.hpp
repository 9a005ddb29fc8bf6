#pragma once

#include <string>

#include "worker/base/observer.hpp"
#include "worker/pipeline/reconstruction.hpp"

// The functions in the rows of the table of stages (reconstruction_stages.cpp), one source file per
// stage. worker/pipeline/stage.hpp specifies load, run, save and finish.
namespace divemesh::pipeline {

// The position of the right camera as estimated from the images; all later stages use it.
bool load_align(Reconstruction& made, const std::string& key);
void run_align(Reconstruction& made, const base::ProgressCallback& progress);
void save_align(Reconstruction& made, const std::string& key);
void finish_align(Reconstruction& made);

// Steps 1 to 6 over all frames.
bool load_track(Reconstruction& made, const std::string& key);
void run_track(Reconstruction& made, const base::ProgressCallback& progress);
void save_track(Reconstruction& made, const std::string& key);
void finish_track(Reconstruction& made);

// The optimised trajectory: loops, bundle adjustment, refined calibration.
bool load_optimise(Reconstruction& made, const std::string& key);
void run_optimise(Reconstruction& made, const base::ProgressCallback& progress);
void save_optimise(Reconstruction& made, const std::string& key);
void finish_optimise(Reconstruction& made);

// Writes the trajectories as they are now: final with covariances, causal, and predicted if a pose
// was not measured.
void write_trajectories(const Reconstruction& made);

// Markers in the scene: their measurements and, if requested, the scale of all that follows.
bool markers_wanted(const Reconstruction& made);
void run_markers(Reconstruction& made, const base::ProgressCallback& progress);

// A reconstruction that has failed makes neither markers nor surface.
bool surface_wanted(const Reconstruction& made);

// Step 7: volume and cloud.
bool load_fuse(Reconstruction& made, const std::string& key);
void run_fuse(Reconstruction& made, const base::ProgressCallback& progress);
void save_fuse(Reconstruction& made, const std::string& key);
void finish_fuse(Reconstruction& made);

// Step 8: the surface.
bool load_mesh(Reconstruction& made, const std::string& key);
void run_mesh(Reconstruction& made, const base::ProgressCallback& progress);
void save_mesh(Reconstruction& made, const std::string& key);
void finish_mesh(Reconstruction& made);
// Starts to write mesh.ply, in the background.
void write_mesh(Reconstruction& made);

// The colour of the water, and that of the surface without it.
bool color_wanted(const Reconstruction& made);
bool load_color(Reconstruction& made, const std::string& key);
void run_color(Reconstruction& made, const base::ProgressCallback& progress);
void save_color(Reconstruction& made, const std::string& key);
void finish_color(Reconstruction& made);

// These show the surface: GLB with the photographs, keyframe images, mosaic and heights.
bool load_texture(Reconstruction& made, const std::string& key);
void run_texture(Reconstruction& made, const base::ProgressCallback& progress);
void save_texture(Reconstruction& made, const std::string& key);
void finish_texture(Reconstruction& made);

// The errors relative to the dive's truth.
void run_evaluate(Reconstruction& made, const base::ProgressCallback& progress);

}  // namespace divemesh::pipeline
