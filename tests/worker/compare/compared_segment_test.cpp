#include "worker/compare/compared_segment.hpp"

#include <gmock/gmock.h>

#include "schemas/error.hpp"
#include "tests/synthetic/small_reconstruction.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/compare/free_space.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;
using synthetic::segment_json;
using testing::HasSubstr;

// A triangle each at x = 0, 10 and 20, seen by two keyframes each; the segment in the middle has
// the most frames.
class ComparedSegmentTest : public testing::Test {
protected:
    types::Mesh mesh_;
    json segments_ = {segment_json(20, 0, 1), segment_json(50, 2, 3), segment_json(20, 4, 5)};
    TemporaryFolder folder_;

    void SetUp() override {
        for (const float x : {0.0F, 10.0F, 20.0F}) {
            const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
            mesh_.triangles.push_back({first, first + 1, first + 2});
            for (const Eigen::Vector3f& corner :
                 {Eigen::Vector3f(x, 0, 0), Eigen::Vector3f(x + 1, 0, 0), Eigen::Vector3f(x, 1, 0)})
                mesh_.vertices.push_back(corner);
        }
        mesh_.normals.assign(mesh_.vertices.size(), Eigen::Vector3f::UnitZ());
        synthetic::write_keyframes(folder_.path(), {0.0, 1.0, 10.0, 11.0, 20.0, 21.0});
    }

    io::ReconstructionFolder folder() const {
        synthetic::write_reconstruction(folder_.path(), mesh_, {{"pieces", segments_}});
        return io::ReconstructionFolder(folder_.path());
    }
    std::string refusal() const {
        try {
            compared_surface(folder());
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::BadData);
            return error.what();
        }
        return "";
    }
};

TEST_F(ComparedSegmentTest, IsTheSurfaceAndTheViewsOfTheLargestSegment) {
    const types::Mesh mesh = compared_surface(folder());
    ASSERT_EQ(mesh.triangles.size(), 1U);
    ASSERT_EQ(mesh.vertices.size(), 3U);
    EXPECT_EQ(mesh.normals.size(), 3U);
    EXPECT_EQ(mesh.vertices[0].x(), 10.0F);
    const auto views = read_views(folder());
    ASSERT_TRUE(views);
    ASSERT_EQ(views->T_cam_world.size(), 2U);
    EXPECT_NEAR(views->T_cam_world[1].inverse().translation().x(), 11.0, 1e-9);
}

TEST_F(ComparedSegmentTest, IsTheWholeDiveInOneSegmentAndOfAnOlderVersion) {
    for (const json& segments : {json::array({segment_json(90, 0, 5)}), json::array()}) {
        segments_ = segments;
        EXPECT_EQ(compared_surface(folder()).triangles.size(), 3U);
        EXPECT_EQ(compared_keyframes(folder()).size(), 6U);
    }
}

TEST_F(ComparedSegmentTest, IsRefusedWhereItsSurfaceTouchesThatOfAnother) {
    mesh_.triangles.push_back({0, 1, 3});  // from x = 1 to 10
    EXPECT_THAT(refusal(), HasSubstr("max_depth_m"));
}

TEST_F(ComparedSegmentTest, IsRefusedWhereTheKeyframesDoNotTellTheSegmentsApart) {
    segments_[2] = segment_json(20, 9, 9);  // none of its keyframes is known
    EXPECT_THAT(refusal(), HasSubstr("reconstruct it again"));
    segments_ = {segment_json(50, 0, 2), segment_json(20, 3, 3), segment_json(20, 4, 5)};
    synthetic::write_keyframes(folder_.path(), {0.0, 1.0, 12.0, 11.0, 20.0, 21.0});
    EXPECT_THAT(refusal(), HasSubstr("reconstruct it again"));
}

}  // namespace
}  // namespace divemesh::compare
