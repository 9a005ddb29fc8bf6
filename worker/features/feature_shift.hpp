#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "worker/types/feature.hpp"

namespace divemesh::features {

// How far a picture has moved on, by the features that it shares with an earlier one.
class FeatureShift {
public:
    struct Shift {
        std::size_t num_shared = 0;
        double median_px = 0.0;
    };

    void start(const types::Features& features);
    Shift since(const types::Features& features) const;

private:
    std::unordered_map<std::int64_t, Eigen::Vector2d> pixels_;  // at the start, by id
};

}  // namespace divemesh::features
