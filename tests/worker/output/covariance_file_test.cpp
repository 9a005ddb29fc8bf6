#include "worker/output/covariance_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <regex>
#include <sstream>

#include "tests/temporary_folder.hpp"

namespace divemesh::worker {
namespace {

// A spreadsheet takes a cell for a formula that begins with = + - @ or a tab: but for the heading,
// which is ours, every cell of the only table that we write is a number.
TEST(CovarianceFileTest, S17EveryCellIsANumber) {
    const TemporaryFolder folder;
    CovarianceTrack track(2);
    track[0].timestamp_ns = 1'600'000'000'000'000'000;
    track[0].position_m2.setConstant(-0.25);
    track[1].timestamp_ns = 1'600'000'000'100'000'000;
    track[1].rotation_rad2.setConstant(std::numeric_limits<double>::quiet_NaN());

    write_covariances(folder / "trajectory_covariance.csv", track);

    std::ifstream file(folder / "trajectory_covariance.csv");
    std::string line;
    ASSERT_TRUE(std::getline(file, line));
    EXPECT_TRUE(std::regex_match(
        line, std::regex(R"(#[a-z_]+ \[ns\](,[pr]_[xyz]{2}( \[[a-z^2]+\])?){12})")))
        << line;
    const std::regex row(R"(\d+(,(-?\d\.\d{6}e[+-]\d\d|-?nan)){12})");
    int num_rows = 0;
    for (; std::getline(file, line); ++num_rows) EXPECT_TRUE(std::regex_match(line, row)) << line;
    EXPECT_EQ(num_rows, 2);
}

}  // namespace
}  // namespace divemesh::worker
