#include "worker/compare/marker_positions.hpp"

#include "tests/worker/io/test_files.hpp"

namespace divemesh::compare {
namespace {

class MarkerPositionsTest : public io::FileTest {
protected:
    std::vector<MarkerPosition> positions(const std::string& metrics) {
        write("metrics.json", metrics);
        return marker_positions(io::ReconstructionFolder(file("")));
    }
};

TEST_F(MarkerPositionsTest, GivesTheMarkersOfTheLargestSegment) {
    const auto found = positions(R"({"pieces": [{"num_frames": 3}, {"num_frames": 9}],
        "markers": {"markers": [
            {"id": 1, "family": "tag25h9", "piece": 0, "position_m": [0, 0, 0],
             "covariance_m2": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]},
            {"id": 4, "family": "tag25h9", "piece": 1, "position_m": [1, 2, 3],
             "covariance_m2": [[1, 0.5, 0], [0.5, 2, 0], [0, 0, 3]]}]}})");

    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].id, 4);
    EXPECT_EQ(found[0].family, "tag25h9");
    EXPECT_EQ(found[0].p_world, Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(found[0].covariance_m2(0, 1), 0.5);
    EXPECT_EQ(found[0].covariance_m2(2, 2), 3.0);
}

TEST_F(MarkerPositionsTest, AReconstructionWithoutMarkersHasNone) {
    EXPECT_TRUE(positions(R"({"pieces": []})").empty());
}

TEST_F(MarkerPositionsTest, ABrokenSectionNamesItsFile) {
    const Error error = io::error_of(
        [&] { positions(R"({"pieces": [], "markers": {"markers": [{"id": "x"}]}})"); });

    EXPECT_EQ(error.code(), ErrorCode::BadData);
    EXPECT_NE(std::string(error.what()).find("metrics.json, markers"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::compare
