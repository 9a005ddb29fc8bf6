#pragma once

#include <string>

namespace divemesh::fusion {

inline bool chooses(const std::string& estimator) { return estimator == "pairwise"; }

}  // namespace divemesh::fusion
