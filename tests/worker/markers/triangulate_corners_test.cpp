#include "worker/markers/triangulate_corners.hpp"

#include <gtest/gtest.h>

#include <random>

namespace divemesh::markers {
namespace {

constexpr double kFocal_px = 400.0;

CornerView view_from(double x_m) {
    CornerView view;
    view.focal_px = kFocal_px;
    view.principal_px = {320.0, 240.0};
    view.T_cam_world.translation().x() = -x_m;
    return view;
}

// Returns two views of a tag of 1 m from places 0.1 m apart, read with noise of a pixel.
std::vector<CornerView> noisy_views(double range_m, std::mt19937& random) {
    std::normal_distribution<double> noise_px;
    std::vector<CornerView> views = {view_from(0.0), view_from(0.1)};
    for (CornerView& view : views)
        for (std::size_t corner = 0; corner < dive::kNumTagCorners; ++corner) {
            const Eigen::Vector3d p_cam =
                view.T_cam_world *
                Eigen::Vector3d(corner % 2 == 0 ? 0.5 : -0.5, corner < 2 ? 0.5 : -0.5, range_m);
            view.corners_px[corner] = kFocal_px / p_cam.z() * p_cam.head<2>() + view.principal_px +
                                      Eigen::Vector2d(noise_px(random), noise_px(random));
        }
    return views;
}

double squares_px2(const std::vector<CornerView>& views,
                   std::size_t corner,
                   const Eigen::Vector3d& p_world) {
    double squares = 0.0;
    for (const CornerView& view : views)
        squares += view.residual_px(corner, p_world)->squaredNorm();
    return squares;
}

// The farther a tag, the less two views tell its range: there either a min is found or nothing.
TEST(TriangulateCornersTest, WhatIsReturnedIsAMinOfTheReprojectionError) {
    std::mt19937 random(1);
    int num_found = 0;
    int num_refused = 0;
    for (int draw = 0; draw < 400; ++draw) {
        const auto views = noisy_views(1.0 + 0.04 * draw, random);
        const auto corners = triangulate_corners(views);
        if (!corners) {
            ++num_refused;
            continue;
        }
        ++num_found;
        for (std::size_t corner = 0; corner < dive::kNumTagCorners; ++corner) {
            const Eigen::Vector3d& p = (*corners)[corner];
            const double here = squares_px2(views, corner, p);
            for (const double share : {0.7, 0.9, 0.97, 1.03, 1.1, 1.5})
                EXPECT_GE(squares_px2(views, corner, share * p), here - 1e-3)
                    << p.z() << " m, " << share;
        }
    }
    EXPECT_GT(num_found, 100);
    EXPECT_GT(num_refused, 0);
}

}  // namespace
}  // namespace divemesh::markers
