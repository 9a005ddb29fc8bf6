#include "worker/mesh/run_phase.hpp"

namespace divemesh::mesh {

void run_phase(const fusion::SignedDistanceField& field,
               const MeshingSettings& settings,
               double begin,
               double end,
               std::size_t num,
               const std::function<void(std::size_t)>& work) {
    base::ProgressShare share = settings.progress;
    share.report = [&](const Progress& progress) {
        field.release_memory();
        settings.progress.report(progress);
    };
    const double whole = share.end - share.begin;
    share.end = share.begin + whole * end;
    share.begin += whole * begin;
    base::for_each_index(settings.num_threads, num, share, work);
}

}  // namespace divemesh::mesh
