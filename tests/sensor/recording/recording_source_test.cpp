#include "sensor/recording/recording_source.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "tests/paths.hpp"
#include "tests/sensor/growing_dive.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using namespace std::chrono_literals;

class WatchTest : public testing::Test {
protected:
    const RecordingState& look(Clock::duration pause = 100ms) {
        source_->update(now_ += pause);
        return source_->state();
    }

    TemporaryFolder folder_;
    std::unique_ptr<RecordingSource> source_ = watch_folder(folder_ / "dives", {});
    Clock::time_point now_ = Clock::now();
};

TEST_F(WatchTest, WaitsForAFolderThatIsNotThereYet) {
    EXPECT_EQ(look().errors.size(), 1u);
    GrowingDive dive(folder_ / "dives" / "wreck");
    dive.add_frame();
    const RecordingState& state = look(3s);
    EXPECT_TRUE(state.errors.empty());
    EXPECT_EQ(state.counts.num_frames, 1);
    EXPECT_TRUE(state.storage_free_bytes);
}

TEST_F(WatchTest, TellsADiveThatGrows) {
    GrowingDive dive(folder_ / "dives" / "wreck");
    for (int i = 0; i < 10; ++i) dive.add_frame();
    EXPECT_FALSE(look().is_recording);  // it may be an old one
    std::int64_t newest = 0;
    for (int i = 0; i < 10; ++i) newest = dive.add_frame();
    const RecordingState& state = look();
    EXPECT_TRUE(state.is_recording);
    EXPECT_EQ(state.dive, "wreck");
    EXPECT_EQ(state.counts.num_frames, 20);
    EXPECT_EQ(state.counts.num_dropped_frames, 0);
    EXPECT_NEAR(state.counts.frame_rate_hz.value_or(0.0), 10.0, 1e-6);
    ASSERT_TRUE(source_->newest_frame());
    EXPECT_EQ(source_->newest_frame()->timestamp_ns, newest);
    EXPECT_FALSE(source_->newest_frame()->right.empty());
}

TEST_F(WatchTest, CountsWhatIsMissing) {
    GrowingDive dive(folder_ / "dives");
    for (int i = 0; i < 10; ++i) dive.add_frame();
    dive.skip_frames(3);
    dive.add_frame();
    EXPECT_EQ(look().counts.num_dropped_frames, 3);
}

TEST_F(WatchTest, LeavesHalfALineAndHalfAnImageForLater) {
    GrowingDive dive(folder_ / "dives");
    const std::int64_t whole = dive.add_frame();
    dive.write("cam0", dive.row().substr(0, 12));
    EXPECT_EQ(look().counts.num_frames, 1);
    dive.write("cam0", dive.row().substr(12));
    dive.write("cam1", dive.row());
    dive.write_image("cam0", "\x89PNG\r\n\x1a\n half an image");
    EXPECT_EQ(look().counts.num_frames, 2);
    ASSERT_TRUE(source_->newest_frame());
    EXPECT_EQ(source_->newest_frame()->timestamp_ns, whole);
}

TEST_F(WatchTest, ReadsNothingOutsideTheDive) {
    GrowingDive dive(folder_ / "dives");
    dive.write("cam0", "1600000000000000000,../../secret.png\n");
    dive.write("cam1", "1600000000000000000,../../secret.png\n");
    cv::imwrite((folder_ / "dives" / "secret.png").string(), cv::Mat(8, 8, CV_8U, cv::Scalar(1)));
    look();
    EXPECT_FALSE(source_->newest_frame());
}

TEST_F(WatchTest, SurvivesAFolderThatDisappears) {
    {
        GrowingDive dive(folder_ / "dives" / "wreck");
        dive.add_frame();
        look();
    }
    std::filesystem::remove_all(folder_ / "dives");
    EXPECT_FALSE(look(3s).errors.empty());
    EXPECT_FALSE(source_->newest_frame());
    GrowingDive dive(folder_ / "dives" / "reef");
    dive.add_frame();
    EXPECT_TRUE(look(3s).errors.empty());
    EXPECT_EQ(source_->state().counts.num_frames, 1);
}

TEST_F(WatchTest, TellsThatNothingIsRecordedAndThenThatTheDiveIsOver) {
    GrowingDive dive(folder_ / "dives" / "wreck");
    dive.add_frame();
    look();
    dive.add_frame();
    EXPECT_TRUE(look().is_recording);
    EXPECT_FALSE(look(5s).is_recording);
    EXPECT_EQ(source_->state().dive, "wreck");  // open, and nothing recorded: an alarm
    EXPECT_FALSE(source_->take_finished());
    look(60s);
    EXPECT_EQ(source_->state().dive, "");
    EXPECT_EQ(source_->take_finished(), folder_ / "dives" / "wreck");
    look(60s);
    EXPECT_FALSE(source_->take_finished());
}

TEST_F(WatchTest, TakesTheMarkerForTheEnd) {
    GrowingDive dive(folder_ / "dives" / "wreck");
    dive.add_frame();
    look();
    dive.add_frame();
    look();
    std::ofstream(folder_ / "dives" / "wreck" / "recording.done");
    look();
    EXPECT_FALSE(source_->state().is_recording);
    EXPECT_TRUE(source_->take_finished());
}

TEST_F(WatchTest, GoesOnWithTheNewestDive) {
    GrowingDive first(folder_ / "dives" / "a");
    first.add_frame();
    look();
    GrowingDive second(folder_ / "dives" / "b");
    second.add_frame();
    second.add_frame();
    look(3s);
    EXPECT_EQ(source_->state().dive, "b");
    EXPECT_EQ(source_->state().counts.num_frames, 2);
}

TEST_F(WatchTest, TakesRubbishInATable) {
    GrowingDive dive(folder_ / "dives");
    dive.write("cam0", std::string(100'000, 'x'));
    dive.write("cam0", "\n,,,\nnan,1.png\n-5,2.png\n99999999999999999999999,3.png\n");
    dive.add_frame();
    EXPECT_EQ(look().counts.num_frames, 2);
}

TEST(ReplayTest, TakesItsTime) {
    const TemporaryFolder folder;
    GrowingDive dive(folder.path());
    for (int i = 0; i < 30; ++i) dive.add_frame();
    const auto source = replay_dive(folder.path(), 2.0);
    const auto begin = Clock::now();
    source->update(begin);
    EXPECT_EQ(source->state().counts.num_frames, 1);
    source->update(begin + 500ms);
    EXPECT_EQ(source->state().counts.num_frames, 11);
    EXPECT_TRUE(source->state().is_recording);
    EXPECT_FALSE(source->take_finished());
    source->update(begin + 10s);
    EXPECT_EQ(source->state().counts.num_frames, 30);
    EXPECT_FALSE(source->state().is_recording);
    EXPECT_TRUE(source->take_finished());
    source->update(begin + 11s);
    EXPECT_FALSE(source->take_finished());
}

TEST(ReplayTest, RefusesWhatIsNoDive) {
    const TemporaryFolder folder;
    EXPECT_THROW(replay_dive(folder.path(), 1.0), Error);
}

TEST(ReplayTest, TellsAllThatTheTankHas) {
    if (!std::filesystem::exists(shared_data("tank"))) GTEST_SKIP() << "the tank is not there";
    const auto source = replay_dive(shared_data("tank"), 1.0);
    const auto begin = Clock::now();
    source->update(begin);
    source->update(begin + 5s);
    const RecordingCounts& counts = source->state().counts;
    EXPECT_EQ(counts.num_frames, 51);
    EXPECT_NEAR(counts.frame_rate_hz.value_or(0.0), 10.0, 0.01);
    EXPECT_NEAR(counts.imu_rate_hz.value_or(0.0), 200.0, 0.1);
    EXPECT_TRUE(counts.orientation);
}

}  // namespace
}  // namespace divemesh::sensor
