#include "worker/loops/strongest_loops.hpp"

namespace divemesh::loops {

std::vector<std::size_t> strongest_loops(const std::vector<Loop>& loops,
                                         const DriftModel& drift,
                                         std::size_t num_wanted) {
    const std::size_t max_run = (loops.size() + num_wanted - 1) / num_wanted;
    const auto joins_the_same = [&](const Loop& a, const Loop& b) {
        return drift.segment(a.from) == drift.segment(b.from) &&
               drift.segment(a.to) == drift.segment(b.to);
    };
    std::vector<std::size_t> result;
    std::size_t first = 0;  // first loop of the run
    for (std::size_t i = 0; i < loops.size(); ++i) {
        if (i == 0 || i - first == max_run || !joins_the_same(loops[first], loops[i])) {
            first = i;
            result.push_back(i);
        } else if (loops[i].reobservations.size() > loops[result.back()].reobservations.size()) {
            result.back() = i;
        }
    }
    return result;
}

}  // namespace divemesh::loops
