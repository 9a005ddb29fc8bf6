#include "storage/dive_store.hpp"

#include <gmock/gmock.h>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;
using DiveStoreTest = StoreTest;

TEST_F(DiveStoreTest, ADiveComesWithItsIntakeJobAndTheReconstructionAskedFor) {
    const CreatedDive created = create_dive("wreck", "paper");

    EXPECT_FALSE(created.existed);
    EXPECT_EQ(created.dive.state, DiveState::Checking);
    EXPECT_THAT(created.dive.id, testing::MatchesRegex("dive_[0-9a-v]+"));
    const Job job = jobs_.get(created.job_id);
    EXPECT_EQ(job.state, JobState::Held);
    EXPECT_EQ(job.preset, "paper");
    EXPECT_EQ(claim().job.kind, JobKind::Intake);
    EXPECT_THAT(event_types(created.dive.id), ElementsAre("dive.created"));
}

TEST_F(DiveStoreTest, AskedTwiceForOneUploadItAnswersTheSameDiveAndJob) {
    const Upload upload = finished_upload();

    const CreatedDive first = dives_.create(request(upload, "wreck", "standard"));
    const CreatedDive second = dives_.create(request(upload, "wreck", "standard"));

    EXPECT_EQ(second.dive.id, first.dive.id);
    EXPECT_EQ(second.job_id, first.job_id);
    EXPECT_FALSE(second.existed);  // its archive is the dive's own
    EXPECT_EQ(uploads_.get(upload.id).dive_id, first.dive.id);
}

TEST_F(DiveStoreTest, TheSameContentInAnotherArchiveIsTheSameDive) {
    const Dive tar = create_dive("wreck").dive;
    NewDive zip = request(finished_upload(), "wreck");
    zip.archive_sha256 = sha256_hex("the zip of it");

    const CreatedDive created = dives_.create(zip);

    EXPECT_TRUE(created.existed);
    EXPECT_EQ(created.dive.id, tar.id);
    EXPECT_EQ(created.dive.blob, tar.blob);
}

TEST_F(DiveStoreTest, TheSameArchiveWithoutAStatedContentIsTheSameDive) {
    const Dive dive = create_dive("wreck").dive;
    NewDive again = request(finished_upload(), "wreck");
    again.content_sha256 = "";

    EXPECT_EQ(dives_.create(again).dive.id, dive.id);
}

TEST_F(DiveStoreTest, ProjectsDoNotSeeEachOthersRecordings) {
    const Dive mine = create_dive("wreck").dive;
    const CreatedDive theirs = dives_.create(request(finished_upload("other"), "wreck"));

    EXPECT_FALSE(theirs.existed);
    EXPECT_NE(theirs.dive.id, mine.id);
    EXPECT_EQ(dives_.list({.project = "other"}, {}).items.size(), 1u);
}

TEST_F(DiveStoreTest, ARefusedRecordingMayComeAgain) {
    const Dive refused = create_dive("wreck").dive;
    finish_intake(refused, {.findings = {{.severity = Severity::Error, .message = "empty"}}});

    const CreatedDive again = create_dive("wreck");

    EXPECT_FALSE(again.existed);
    EXPECT_NE(again.dive.id, refused.id);
}

TEST_F(DiveStoreTest, IntakeTellsWhatIsInTheDive) {
    const Dive dive = create_dive("wreck").dive;
    finish_intake(dive,
                  {.findings = {{.severity = Severity::Warning, .code = "imu_gap"}},
                   .name = "SS Example",
                   .site = "north reef",
                   .tags = {"wreck", "deep"},
                   .content_sha256 = dive.content_sha256,
                   .num_frames = 1200,
                   .duration_s = 60.5,
                   .thumbnail_blob = "dives/x/thumbnail.jpg"});

    const Dive ready = dives_.get(dive.id);
    EXPECT_EQ(ready.state, DiveState::Ready);
    EXPECT_EQ(ready.name, "SS Example");
    EXPECT_EQ(ready.site, "north reef");
    EXPECT_THAT(ready.tags, ElementsAre("wreck", "deep"));
    EXPECT_EQ(ready.num_frames, 1200);
    EXPECT_EQ(ready.duration_s, 60.5);
    EXPECT_TRUE(ready.has_thumbnail);
    EXPECT_EQ(dives_.findings(dive.id).at(0).code, "imu_gap");
    EXPECT_EQ(dives_.thumbnail_blob(dive.id), "dives/x/thumbnail.jpg");
    EXPECT_THAT(event_types(dive.id), ElementsAre("dive.created", "dive.ready"));
    EXPECT_EQ(dives_.list({.site = "north reef"}, {}).items.size(), 1u);
    EXPECT_EQ(dives_.list({.state = DiveState::Refused}, {}).items.size(), 0u);
}

TEST_F(DiveStoreTest, ARecordingThatIsNotWhatItsClientAnnouncedIsRefused) {
    const Dive dive = create_dive("wreck").dive;

    finish_intake(dive, {.content_sha256 = {sha256_hex("something else")}});

    EXPECT_EQ(dives_.get(dive.id).state, DiveState::Refused);
    EXPECT_EQ(dives_.findings(dive.id).at(0).code, "content_hash_mismatch");
}

// The digests are what `sha256sum mav0/a | sha256sum` and `sha256sum .DS_Store mav0/a | sha256sum`
// print for files with "seen" and "abc".
TEST_F(DiveStoreTest, ARecordingMayBeAnnouncedByItsHashOfEarlierVersions) {
    const ContentHash hash{
        .sha256 = "2bdb05d3968c2c2844cf36dfaadc22cbd6d1d31165dd7fc86e937ffee61dd58f",
        .with_desktop_files = "10a6d48fa887e10bf52b76bb556a70010548b7d4300d106fd097082f6789494b"};
    NewDive announced = request(finished_upload(), "wreck");
    announced.content_sha256 = hash.with_desktop_files;
    const Dive dive = dives_.create(announced).dive;

    finish_intake(dive, {.content_sha256 = hash});

    EXPECT_EQ(dives_.get(dive.id).state, DiveState::Ready);
    EXPECT_EQ(dives_.get(dive.id).content_sha256, hash.sha256);
}

TEST_F(DiveStoreTest, ARecordingThatTurnsOutToBeHereAlreadyIsRefusedAndNamed) {
    const Dive first = ready_dive("wreck");
    NewDive unstated = request(finished_upload(), "wreck");
    unstated.archive_sha256 = sha256_hex("the zip of it");
    unstated.content_sha256 = "";
    const Dive second = dives_.create(unstated).dive;
    ASSERT_NE(second.id, first.id);

    finish_intake(second, {.content_sha256 = {first.content_sha256}});

    EXPECT_EQ(dives_.get(second.id).state, DiveState::Refused);
    EXPECT_THAT(dives_.findings(second.id).at(0).message, testing::HasSubstr(first.id));
}

TEST_F(DiveStoreTest, UnknownIdsAreNotFound) {
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { dives_.get("dive_x"); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { dives_.findings("dive_x"); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { dives_.thumbnail_blob("dive_x"); }));
    const Dive dive = ready_dive();
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { dives_.thumbnail_blob(dive.id); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] {
        dives_.create({.upload_id = "upload_x", .project = "default"});
    }));
}

}  // namespace
}  // namespace divemesh::storage
