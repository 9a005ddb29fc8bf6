#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "worker/types/feature.hpp"

namespace divemesh::features {

// The distance that an image has moved since an earlier one, from the features that both share.
class FeatureShift {
public:
    struct Shift {
        std::size_t num_shared = 0;
        double median_px = 0.0;
    };

    void start(const types::Features& features);
    Shift since(const types::Features& features) const;

private:
    std::unordered_map<std::int64_t, Eigen::Vector2d> pixels_;  // at start(), by id
};

}  // namespace divemesh::features
