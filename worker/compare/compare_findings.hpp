#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/compare/compare_document.hpp"

namespace divemesh::compare {

// Returns what a reader of the comparison must know about the two reconstructions: ground that was
// left out, their restrictions, an unknown vertical, and scales that differ or are not known well
// enough for the volumes.
std::vector<Finding> compare_findings(const ComparisonResult& result);

}  // namespace divemesh::compare
