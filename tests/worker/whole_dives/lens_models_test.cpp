#include <gtest/gtest.h>

#include <string>

#include "tests/temporary_folder.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

// Renders the same dive with another lens, opens it as any other and follows its path.
double absolute_error_m(types::Distortion lens) {
    const TemporaryFolder folder;
    simulator::SimulateOptions options;
    options.scene = simulator::SceneKind::Barge;
    options.out = folder / "dive";
    options.length_m = 2.0;
    options.seed = 3;
    options.width_px = 320;
    options.height_px = 240;
    options.lens = lens;
    simulator::simulate(options);
    const auto dive = dive::Dive::open(folder / "dive", folder / "scratch");
    const types::Camera truth = simulator::draw_rig(320, 240, 3, lens).cam1;
    EXPECT_EQ(dive->rig().cam1.distortion, lens);
    EXPECT_NEAR(dive->rig().cam1.fx_px, truth.fx_px, 1e-6);
    EXPECT_NEAR(
        dive->rig().cam1.distortion_coefficients[0], truth.distortion_coefficients[0], 1e-9);
    AlignedRecording recording(*dive);
    recording.rewind();
    const keyframes::KeyframeStore store(folder / "keyframes");
    const auto reconstruct = make_options("standard", {{"surface", false}, {"num_threads", 1}});
    const types::Track track =
        pipeline::track(recording, reconstruct, store, base::ignore_progress);
    const types::OptimisedTrack path =
        pipeline::optimise(track, recording, reconstruct, store, {}, base::ignore_progress);
    return evaluation::trajectory_error(path.trajectory, dive->ground_truth()).ate_rmse_m;
}

TEST(LensModelsTest, ADiveOfEveryModelIsReconstructedAsWellAsThatOfAPinhole) {
    const double pinhole_m = absolute_error_m(types::Distortion::None);
    for (const camera::LensModel& model : camera::lens_models()) {
        if (model.distortion == types::Distortion::None) continue;
        EXPECT_LT(absolute_error_m(model.distortion), 1.5 * pinhole_m + 1e-3) << model.name;
    }
}

}  // namespace
}  // namespace divemesh::pipeline
