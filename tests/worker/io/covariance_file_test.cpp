#include "worker/io/covariance_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <regex>
#include <sstream>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::io {
namespace {

// A spreadsheet takes a cell for a formula if it begins with = + - @ or a tab. Except for our own
// heading, every cell of the only table that we write is a number.
TEST(CovarianceFileTest, EveryCellIsANumber) {
    const TemporaryFolder folder;
    types::CovarianceTrack track(2);
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

TEST(CovarianceFileTest, ReadsWhatWasWritten) {
    const TemporaryFolder folder;
    types::CovarianceTrack track(2);
    track[0].timestamp_ns = 1'600'000'000'000'000'000;
    track[1].timestamp_ns = 1'600'000'000'100'000'000;
    track[1].position_m2 << 1, 2, 3, 2, 4, 5, 3, 5, 6;
    track[1].rotation_rad2 = -0.5e-7 * track[1].position_m2;
    write_covariances(folder / "trajectory_covariance.csv", track);
    const types::CovarianceTrack read = read_covariances(folder / "trajectory_covariance.csv");
    ASSERT_EQ(read.size(), 2U);
    EXPECT_EQ(read[1].timestamp_ns, track[1].timestamp_ns);
    EXPECT_TRUE(read[1].position_m2.isApprox(track[1].position_m2, 1e-6));
    EXPECT_TRUE(read[1].rotation_rad2.isApprox(track[1].rotation_rad2, 1e-6));
}

TEST(CovarianceFileTest, NamesTheLineThatIsNone) {
    const TemporaryFolder folder;
    const auto file = folder / "trajectory_covariance.csv";
    for (const char* line : {"5,1,2,3",
                             "5,1,2,3,4,5,6,7,8,9,10,11,12,13",
                             "x,0,0,0,0,0,0,0,0,0,0,0,0",
                             "5,0,0,0,0,0,0,0,0,0,0,0,",
                             "4,0,0,0,0,0,0,0,0,0,0,0,0"}) {
        std::ofstream(file) << "#timestamp\n4,0,0,0,0,0,0,0,0,0,0,0,0\n" << line << "\n";
        try {
            read_covariances(file);
            FAIL() << "read " << line;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::BadData);
            EXPECT_NE(std::string(error.what()).find("line 3"), std::string::npos) << error.what();
        }
    }
    EXPECT_THROW(read_covariances(folder / "none.csv"), Error);
}

}  // namespace
}  // namespace divemesh::io
