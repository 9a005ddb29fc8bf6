#include "worker/stereo/census_sgm.hpp"

#include <gtest/gtest.h>

#include "tests/worker/stereo/reference_sgm.hpp"
#include "tests/worker/stereo/warped_pair.hpp"

namespace divemesh::stereo {
namespace {

// Returns the disparity of a bed with a step. difficult_pair() removes the texture above it,
// because ambiguous matches must agree too.
double bed_with_a_step(double x, double y) { return (x < 150.0 ? 6.0 : 19.0) + 0.05 * y; }

WarpedPair difficult_pair() {
    WarpedPair pair = make_warped_pair(bed_with_a_step);
    pair.left.rowRange(0, 12).setTo(90);
    pair.right.rowRange(0, 12).setTo(90);
    return pair;
}

TEST(CensusSgm, IsToTheBitThePlainMethodOverCostVolumes) {
    const WarpedPair pair = difficult_pair();
    const cv::Rect part(40, 0, 131, 43);  // rows are processed in pairs, and one is left over
    const cv::Mat left = pair.left(part).clone();
    const cv::Mat right = pair.right(part).clone();
    for (const int range : {32, 64, 96, 128, 160})
        for (const int tolerance : {1, 3}) {
            const cv::Mat plain = reference_sgm(left, right, range, tolerance);
            EXPECT_GT(cv::countNonZero(plain), 1500);
            for (int set = 0; set <= static_cast<int>(base::best_instructions()); ++set) {
                const cv::Mat own = CensusSgm(range, static_cast<base::Instructions>(set))
                                        .compute(left, right, {0, range}, tolerance);
                EXPECT_EQ(cv::norm(plain, own, cv::NORM_INF), 0.0) << range << " set " << set;
            }
        }
}

TEST(CensusSgm, EveryInstructionSetGivesTheSameIntegers) {
    if (base::best_instructions() == base::Instructions::Baseline) GTEST_SKIP() << "no AVX2 here";
    const WarpedPair pair = difficult_pair();
    for (const int width : {317, 320})  // whole vectors, and a remainder
        for (const int range : {32, 64, 96, 128, 288}) {
            const cv::Rect part(0, 0, width, 101);
            const cv::Mat plain = CensusSgm(range, base::Instructions::Baseline)
                                      .compute(pair.left(part), pair.right(part));
            EXPECT_GT(cv::countNonZero(plain), 5000);
            for (int set = 1; set <= static_cast<int>(base::best_instructions()); ++set) {
                const cv::Mat wide = CensusSgm(range, static_cast<base::Instructions>(set))
                                         .compute(pair.left(part), pair.right(part));
                EXPECT_EQ(cv::norm(plain, wide, cv::NORM_INF), 0.0) << width << " " << range;
            }
        }
}

}  // namespace
}  // namespace divemesh::stereo
