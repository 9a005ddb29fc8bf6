#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/stereo/census_sgm.hpp"
#include "worker/types/search_outcome.hpp"

namespace divemesh::stereo {

// A survey of how near and how far a scene is, by a search at a quarter of its size, over twice the
// range of the full-size search: it shows what a narrower search would miss, at a few percent of
// its time.
class CoarseDisparitySearch {
public:
    explicit CoarseDisparitySearch(int num_disparities_px);

    // Returns the disparities of patches spread over the left image of a rectified pair (CV_8UC1),
    // accurate to some pixels, ascending. Islands and unconfirmed disparities are left out.
    std::vector<float> survey(const cv::Mat& left, const cv::Mat& right);

private:
    CensusSgm matcher_;
    cv::Mat small_left_, small_right_;
};

// Returns `range` widened to the disparities in `surveyed`, up to `num_disparities_px`. A few
// patches do not widen it: they may be wrong.
types::DisparityRange widen(const types::DisparityRange& range,
                            const std::vector<float>& surveyed,
                            int num_disparities_px);

// Returns how many surveyed patches a search within `range` cannot find.
types::SearchOutcome outcome_of(const types::DisparityRange& range,
                                const std::vector<float>& surveyed);

}  // namespace divemesh::stereo
