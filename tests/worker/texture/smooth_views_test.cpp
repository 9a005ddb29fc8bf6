#include "worker/texture/smooth_views.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/worker/texture/square_mesh.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/texture/merge_charts.hpp"

namespace divemesh::texture {
namespace {

// A plane of 1 m in 2 x 60 x 60 triangles.
class SmoothViews : public testing::Test {
protected:
    // Adds candidates of ascending views to a triangle, each of a quality.
    void add(std::size_t face, const std::vector<std::pair<std::uint16_t, float>>& views) {
        for (const auto& [view, quality] : views)
            candidates_.add(face, {view, Candidate::encoded_quality(quality)});
    }
    ViewField field(float seam_width_m) const {
        const float area_m2 = 1.0F / static_cast<float>(mesh_.triangles.size());
        return {
            candidates_, graph_, std::vector<float>(mesh_.triangles.size(), area_m2), seam_width_m};
    }
    FaceViews best_of_each_face() const { return smooth_views(field(0.0F), 1, {}); }
    std::int64_t num_seams(const FaceViews& views) const {
        std::int64_t num = 0;
        for (std::size_t face = 0; face < views.size(); ++face)
            for (const FaceLink& link : graph_.links(face))
                num += link.face > face && ViewField::is_seam(views, face, link) ? 1 : 0;
        return num;
    }
    double energy(const ViewField& of, const FaceViews& views) const {
        double sum = 0.0;
        for (std::size_t face = 0; face < views.size(); ++face) {
            of.for_each_view(face, [&](std::uint16_t view, float cost) {
                if (view == views[face]) sum += static_cast<double>(cost);
            });
            for (const FaceLink& link : graph_.links(face))
                if (link.face > face && ViewField::is_seam(views, face, link))
                    sum += static_cast<double>(of.seam_cost(link));
        }
        return sum;
    }

    types::Mesh mesh_ = square_mesh(1.0F, 60);
    FaceGraph graph_{mesh_};
    FaceCandidates candidates_{mesh_.triangles.size()};
};

TEST_F(SmoothViews, WithoutACostOfSeamsEachFaceTakesItsBest) {
    for (std::size_t face = 0; face < mesh_.triangles.size(); ++face)
        add(face, {{0, face % 3 == 0 ? 2.0F : 1.0F}, {1, 1.5F}});
    const FaceViews views = best_of_each_face();
    for (std::size_t face = 0; face < views.size(); ++face)
        EXPECT_EQ(views[face], face % 3 == 0 ? 0 : 1);
}

// View 0 is better on the left, view 1 on the right, with noise on both.
TEST_F(SmoothViews, NoiseMakesNoSeams) {
    base::RandomRow random(3);
    for (std::size_t face = 0; face < mesh_.triangles.size(); ++face) {
        const float lead = center_of(mesh_, face).x() < 0.0F ? 1.5F : 1.0F / 1.5F;
        const auto noise = [&] { return std::exp(static_cast<float>(0.4 * random.gaussian())); };
        add(face, {{0, lead * noise()}, {1, noise()}});
    }
    const FaceViews views = smooth_views(field(0.2F), 2, {});
    EXPECT_GT(num_seams(best_of_each_face()), 1000);
    EXPECT_LE(num_seams(views), 70);  // 60 is a straight line
    std::int64_t num_wrong = 0;
    for (std::size_t face = 0; face < views.size(); ++face) {
        const float x_m = center_of(mesh_, face).x();
        if (std::abs(x_m) > 0.1F) num_wrong += views[face] != (x_m < 0.0F ? 0 : 1) ? 1 : 0;
    }
    EXPECT_EQ(num_wrong, 0);
    EXPECT_EQ(views, smooth_views(field(0.2F), 1, {}));
    EXPECT_EQ(views, smooth_views(field(0.2F), 3, {}));
}

TEST_F(SmoothViews, AFaceWithOneCandidateKeepsItAndOneWithoutHasNoView) {
    for (std::size_t face = 0; face < mesh_.triangles.size(); ++face) {
        if (face % 50 == 7) continue;
        if (face % 50 == 9)
            add(face, {{1, 1.0F}});
        else
            add(face, {{0, 1.0F}, {1, 1.1F}, {2, 1.0F}});
    }
    FaceViews views = smooth_views(field(1.0F), 2, {});
    merge_charts(field(1.0F), views);
    for (std::size_t face = 0; face < views.size(); ++face) {
        if (face % 50 == 7)
            EXPECT_EQ(views[face], kNoView);
        else
            EXPECT_EQ(views[face], 1);
    }
}

// The energy of a straight seam across the plane is known. The best place is where the resolutions
// of both are equal.
TEST_F(SmoothViews, FindsAStraightSeamOfLeastEnergy) {
    for (std::size_t face = 0; face < mesh_.triangles.size(); ++face) {
        const float x_m = center_of(mesh_, face).x();
        add(face, {{4, std::exp2(-4.0F * x_m)}, {9, std::exp2(4.0F * x_m)}});
    }
    FaceViews straight(mesh_.triangles.size());
    for (std::size_t face = 0; face < straight.size(); ++face)
        straight[face] = center_of(mesh_, face).x() < 0.0F ? 4 : 9;
    const ViewField of = field(0.2F);
    EXPECT_LE(energy(of, smooth_views(of, 2, {})), 1.001 * energy(of, straight));
}

TEST_F(SmoothViews, MergingChartsLowersTheEnergy) {
    for (std::size_t face = 0; face < mesh_.triangles.size(); ++face) {
        const Eigen::Vector3f center = center_of(mesh_, face).cwiseAbs();
        const bool is_middle = std::max(center.x(), center.y()) < 0.2F;
        add(face, {{0, 1.0F}, {1, is_middle ? 1.1F : 0.5F}});
    }
    const ViewField of = field(0.1F);
    FaceViews views = best_of_each_face();
    EXPECT_EQ(std::set<std::int32_t>(views.begin(), views.end()).size(), 2U);
    const FaceViews before = views;
    descend(of, 2, views);  // only cuts corners
    EXPECT_GT(std::count(views.begin(), views.end(), 1), 900);
    merge_charts(of, views);
    EXPECT_EQ(num_seams(views), 0);
    EXPECT_EQ(views, FaceViews(views.size(), 0));
    EXPECT_LT(energy(of, views), energy(of, before));
}

}  // namespace
}  // namespace divemesh::texture
