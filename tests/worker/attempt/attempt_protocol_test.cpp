#include "worker/attempt/attempt_protocol.hpp"

#include <gtest/gtest.h>

namespace divemesh::attempt {
namespace {

IntakeAnswer passed_on(const IntakeAnswer& answer) {
    return std::get<IntakeAnswer>(decode_message(encode_message(answer)));
}

TEST(AttemptProtocolTest, AnIntakeAnswerPassesWhole) {
    const IntakeAnswer answer{.findings = {{Severity::Warning, "a", "b", "c", "d"}},
                              .name = "Wreck \"7\"",
                              .site = "Bay",
                              .rig = "aqua",
                              .tags = {"2026", "north"},
                              .notes = "two lines\nof \u00e9tude",
                              .position = DivePosition{-12.5, 170.25},
                              .content_sha256 = {"aa", "bb"},
                              .num_frames = 12,
                              .duration_s = 3.5,
                              .has_thumbnail = true};

    const IntakeAnswer read = passed_on(answer);

    ASSERT_EQ(read.findings.size(), 1U);
    EXPECT_EQ(read.findings[0].code, "a");
    EXPECT_EQ(read.name, answer.name);
    EXPECT_EQ(read.site, "Bay");
    EXPECT_EQ(read.rig, "aqua");
    EXPECT_EQ(read.tags, answer.tags);
    EXPECT_EQ(read.notes, answer.notes);
    ASSERT_TRUE(read.position);
    EXPECT_EQ(read.position->latitude_deg, -12.5);
    EXPECT_EQ(read.position->longitude_deg, 170.25);
    EXPECT_EQ(read.content_sha256.sha256, "aa");
    EXPECT_EQ(read.content_sha256.with_desktop_files, "bb");
    EXPECT_EQ(read.num_frames, 12);
    EXPECT_EQ(read.duration_s, 3.5);
    EXPECT_TRUE(read.has_thumbnail);
}

TEST(AttemptProtocolTest, ADiveWithoutPositionHasNone) {
    EXPECT_FALSE(passed_on({}).position);
    EXPECT_EQ(passed_on({}).notes, "");
}

}  // namespace
}  // namespace divemesh::attempt
