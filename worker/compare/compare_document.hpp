#pragma once

#include <nlohmann/json.hpp>

#include "worker/compare/change_patches.hpp"
#include "worker/compare/compare.hpp"
#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::compare {

// A summary of the M3C2 distances of b's vertices.
struct DistanceSummary {
    std::size_t num = 0;        // vertices of b
    std::size_t num_known = 0;  // that have a's surface before or behind them
    double median_m = 0.0;
    double median_abs_m = 0.0;
    double median_lod95_m = 0.0;
    double level_factor =
        1.0;  // factor of the levels of detection, so that they hold on stable ground
};

// The results that compare.json contains.
struct ComparisonResult {
    const io::ReconstructionFolder& a;
    const io::ReconstructionFolder& b;
    const CompareOptions& options;  // as used: no option is left at 0
    const CoRegistration& registration;
    const DistanceSummary& distances;
    const ChangeMap& map;
    const Changes& changes;
    bool visibility_checked = true;
};

// Returns compare.json (schemas/compare.schema.json).
nlohmann::json compare_document(const ComparisonResult& result);

}  // namespace divemesh::compare
