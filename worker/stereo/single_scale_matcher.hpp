#pragma once

#include <memory>
#include <string>
#include <vector>

#include "worker/stereo/search_tiles.hpp"
#include "worker/types/disparity_range.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::stereo {

// Matches pairs as large as they are, by one of the methods of StereoMatcher.
class SingleScaleMatcher {
public:
    SingleScaleMatcher(const std::string& method, int num_disparities_px);
    ~SingleScaleMatcher();
    SingleScaleMatcher(const SingleScaleMatcher&) = delete;
    SingleScaleMatcher& operator=(const SingleScaleMatcher&) = delete;

    // Returns whether match() uses its range; block and opencv_sgbm search all their disparities.
    bool searches_within_range() const;
    // Returns disparities with their standard deviations, px; the outcome of the search is not set.
    types::DepthMap match(const types::RectifiedFrame& frame, const types::DisparityRange& range);
    // The same, each tile within its own range; for methods that search within one.
    types::DepthMap match(const types::RectifiedFrame& frame, const std::vector<SearchTile>& tiles);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::stereo
