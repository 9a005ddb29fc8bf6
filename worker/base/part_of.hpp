#pragma once

#include "worker/base/observer.hpp"

namespace divemesh::base {

// Returns the callback for a part of the work, which covers `begin` to `end` of the whole.
inline ProgressCallback part_of(const ProgressCallback& whole, double begin, double end) {
    return [=](Progress progress) {
        progress.fraction = begin + (end - begin) * progress.fraction;
        whole(progress);
    };
}

}  // namespace divemesh::base
