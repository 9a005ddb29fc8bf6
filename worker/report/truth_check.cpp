#include "worker/report/truth_check.hpp"

#include <vector>

#include "schemas/error.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/reef/area_set.hpp"
#include "worker/report/report_inputs.hpp"

namespace divemesh::report {
namespace {

void read_truth(TruthKind kind, const std::filesystem::path& file) {
    std::vector<Finding> of_single_distances;
    switch (kind) {
        case TruthKind::GroundTruth: io::read_trajectory(file); return;
        case TruthKind::Reference: io::read_mesh(file); return;
        case TruthKind::Measurements: read_known_distances(file, of_single_distances); return;
        case TruthKind::Areas: reef::read_areas(file); return;
    }
}

}  // namespace

std::string problem_of_truth(TruthKind kind, const std::filesystem::path& file) {
    try {
        read_truth(kind, file);
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

}  // namespace divemesh::report
