#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/stereo/census_sgm.hpp"
#include "worker/types/search_outcome.hpp"

namespace divemesh::stereo {

// How near and how far a scene lies, from a search at a quarter of its size, over twice the range
// that is searched at full size: it shows what a narrower search would miss, for some hundredths
// of its time.
class CoarseDisparitySearch {
public:
    explicit CoarseDisparitySearch(int num_disparities_px);

    // CV_8UC1 rectified pair -> disparities of patches spread over the left picture, to some
    // pixels, ascending; those of islands and of what is not confirmed are left out.
    std::vector<float> survey(const cv::Mat& left, const cv::Mat& right);

private:
    CensusSgm matcher_;
    cv::Mat small_left_, small_right_;
};

// `range`, with what `surveyed` shows beyond it as far as `num_disparities_px` goes. Few patches
// are not followed: they may be wrong.
types::DisparityRange widen(const types::DisparityRange& range,
                            const std::vector<float>& surveyed,
                            int num_disparities_px);

// How much of what was surveyed a search within `range` cannot find.
types::SearchOutcome outcome_of(const types::DisparityRange& range,
                                const std::vector<float>& surveyed);

}  // namespace divemesh::stereo
