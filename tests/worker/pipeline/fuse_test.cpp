#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/fusion/synthetic_views.hpp"
#include "worker/fusion/voxel_size.hpp"
#include "worker/pipeline/reconstruct.hpp"

namespace divemesh::pipeline {
namespace {

// Four views of a bump, in the store.
class FuseOnThreads : public testing::TestWithParam<int> {
protected:
    FuseOnThreads() {
        for (const auto& pose : fusion::views_from_above(4, 1.2)) {
            auto view = fusion::render_view(fusion::bump_on_floor, fusion::small_rig(), pose);
            view.keyframe.frame_index = static_cast<int>(frames_.size());
            store_.write(view.keyframe.frame_index, view.images.depth);
            images_.push_back(view.images.left_color);
            frames_.push_back(view.keyframe);
        }
        options_.voxel_m = 0.02;
        options_.num_threads = GetParam();
    }

    FusedMap fuse(const base::ProgressCallback& progress, double median_depth_m = 1.2) const {
        return pipeline::fuse({fusion::small_rig(), frames_, median_depth_m, store_},
                              options_,
                              folder_ / "",
                              progress);
    }

    TemporaryFolder folder_;
    std::vector<cv::Mat> images_;
    keyframes::KeyframeStore store_{folder_ / "keyframes",
                                    [this](int frame_index) { return images_.at(frame_index); }};
    std::vector<types::Keyframe> frames_;
    ReconstructionOptions options_;
};

// The next keyframe is being read when the callback throws: its buffer must live until the read
// ends.
TEST_P(FuseOnThreads, IsCancelledAtAnyFrame) {
    for (std::int64_t last = 0; last <= std::ssize(frames_); ++last) {
        std::int64_t frames_done = -1;
        try {
            fuse([&](const Progress& progress) {
                frames_done = progress.frames_done;
                if (frames_done == last) throw Error(ErrorCode::Cancelled, "enough");
            });
            ADD_FAILURE() << "went on after frame " << last;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Cancelled);
        }
        EXPECT_EQ(frames_done, last);
    }
}

TEST_P(FuseOnThreads, AKeyframeThatIsNotInTheStoreIsATypedError) {
    store_.clear();
    try {
        fuse(base::ignore_progress);
        ADD_FAILURE() << "fused frames that are not there";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::NotFound);
    }
}

// A dive of one frame has no tracked features, and so no median depth of them.
TEST_P(FuseOnThreads, TheVoxelOfASingleFrameComesFromItsDepth) {
    frames_.resize(1);
    options_.voxel_m = 0.0;
    const double voxel_m = fuse(base::ignore_progress, 0.0).volume->voxel_m();
    EXPECT_NEAR(voxel_m, fusion::choose_voxel_m(fusion::small_rig(), 1.2), 0.1 * voxel_m);
}

INSTANTIATE_TEST_SUITE_P(Threads, FuseOnThreads, testing::Values(1, 2));

}  // namespace
}  // namespace divemesh::pipeline
