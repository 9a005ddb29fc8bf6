#include "worker/pipeline/check_cameras.hpp"

#include "schemas/error.hpp"
#include "worker/pipeline/align_cameras.hpp"
#include "worker/pipeline/alignment_findings.hpp"

namespace divemesh::pipeline {

std::vector<Finding> check_cameras(const types::Recording& recording,
                                   const base::ProgressCallback& progress) {
    try {
        return alignment_findings(align_cameras(recording, 0, progress));
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        return {};
    }
}

}  // namespace divemesh::pipeline
