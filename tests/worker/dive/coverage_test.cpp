#include "worker/dive/coverage.hpp"

#include <gtest/gtest.h>

#include "tests/worker/dive/finding_matcher.hpp"

namespace divemesh::dive {
namespace {

// Ten pairs a second for five minutes on a clock that begins at 0.
DiveContents images_of_five_minutes() {
    DiveContents contents;
    for (int i = 0; i <= 3000; ++i) {
        FramePair pair;
        pair.timestamp_ns = i * std::int64_t{100'000'000};
        contents.frames.pairs.push_back(pair);
    }
    return contents;
}

std::vector<types::PressureSample> readings(std::int64_t period, int num) {
    std::vector<types::PressureSample> samples;
    for (int i = 0; i < num; ++i) samples.push_back({i * period, 7.0});
    return samples;
}

TEST(CoverageTest, MicrosecondsFromZeroAreToldByTheLengthOfTheDive) {
    DiveContents contents = images_of_five_minutes();
    contents.pressure = readings(100'000, 3001);
    FindingLog findings;

    check_coverage(contents, findings);

    EXPECT_THAT(findings.all(),
                HasFinding(Severity::Error, "pressure_timestamp_unit", "microseconds"));
    EXPECT_TRUE(contents.pressure.empty());
}

TEST(CoverageTest, ASensorThatStopsIsNotOfAnotherUnit) {
    DiveContents contents = images_of_five_minutes();
    contents.pressure = readings(10'000'000, 300);  // three seconds
    FindingLog findings;

    check_coverage(contents, findings);

    EXPECT_THAT(findings.all(), HasFinding(Severity::Warning, "pressure_partial", "2.99 s"));
    EXPECT_FALSE(contents.pressure.empty());
}

}  // namespace
}  // namespace divemesh::dive
