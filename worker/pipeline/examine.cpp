#include "worker/pipeline/examine.hpp"

#include "worker/dive/refusal.hpp"
#include "worker/pipeline/check_cameras.hpp"
#include "worker/recording/recorded_dive.hpp"

namespace divemesh::pipeline {

dive::IntakeReport examine(const std::filesystem::path& path,
                           const std::filesystem::path& scratch,
                           const base::ProgressCallback& progress,
                           Links links) {
    try {
        return dive::examine_dive(
            recording::as_dive(path, scratch, progress), scratch, progress, check_cameras, links);
    } catch (const dive::Refusal& refusal) {
        dive::IntakeReport report;
        report.findings.push_back(refusal.finding());
        return report;
    }
}

}  // namespace divemesh::pipeline
