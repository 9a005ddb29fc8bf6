#include "worker/dive/clock_set_back.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "worker/base/text.hpp"
#include "worker/dive/stamp_check.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kMaxSteps = 3;
constexpr std::size_t kMinRunRows = 10;

// Returns the rows before which time goes back.
std::vector<std::size_t> steps_back(const std::vector<std::int64_t>& timestamps_ns) {
    std::vector<std::size_t> steps;
    for (std::size_t row = 1; row < timestamps_ns.size(); ++row)
        if (timestamps_ns[row] < timestamps_ns[row - 1]) steps.push_back(row);
    return steps;
}

std::vector<std::int64_t> values_of(const TableStamps& table) {
    std::vector<std::int64_t> values;
    values.reserve(table.timestamps_ns.size());
    for (const std::int64_t* timestamp_ns : table.timestamps_ns) values.push_back(*timestamp_ns);
    return values;
}

// Returns by how much the k-th step has to move what follows it, so that every table still rises.
std::int64_t shift_ns(const std::vector<std::vector<std::int64_t>>& tables,
                      const std::vector<std::vector<std::size_t>>& steps,
                      std::size_t k) {
    std::int64_t largest_step_ns = 0;
    std::int64_t shortest_period_ns = std::numeric_limits<std::int64_t>::max();
    for (std::size_t i = 0; i < tables.size(); ++i) {
        const std::size_t row = steps[i][k];
        largest_step_ns = std::max(largest_step_ns, tables[i][row - 1] - tables[i][row]);
        shortest_period_ns = std::min(shortest_period_ns, median_period_ns(tables[i]));
    }
    return largest_step_ns + std::max<std::int64_t>(1, shortest_period_ns);
}

void move_rows(TableStamps& table, std::size_t from, std::int64_t by_ns) {
    for (std::size_t row = from; row < table.timestamps_ns.size(); ++row)
        *table.timestamps_ns[row] += by_ns;
}

void report_difference(const TableStamps& a,
                       std::size_t num_a,
                       const TableStamps& b,
                       std::size_t num_b,
                       FindingLog& findings) {
    findings.error("clock_set_back",
                   a.file,
                   "time goes back " + std::to_string(num_a) + " times in " + a.file + " and " +
                       std::to_string(num_b) + " times in " + b.file +
                       ", so it is not known which rows belong together",
                   "Cut the dive in two where the clock was set: two folders, each with the rows "
                   "of all sensors on its side of it.");
}

}  // namespace

bool is_set_back(const std::vector<std::int64_t>& timestamps_ns) {
    std::vector<std::size_t> bounds = steps_back(timestamps_ns);
    if (bounds.empty() || bounds.size() > kMaxSteps) return false;
    bounds.insert(bounds.begin(), 0);
    bounds.push_back(timestamps_ns.size());
    for (std::size_t run = 1; run < bounds.size(); ++run) {
        if (bounds[run] - bounds[run - 1] < kMinRunRows) return false;
        const bool is_last = run + 1 == bounds.size();
        if (!is_last && timestamps_ns[bounds[run]] <= timestamps_ns[bounds[run - 1]]) return false;
    }
    return true;
}

void undo_set_backs(std::vector<TableStamps>& tables, FindingLog& findings) {
    std::vector<std::vector<std::int64_t>> stamps;
    std::vector<std::vector<std::size_t>> steps;
    for (const TableStamps& table : tables) {
        stamps.push_back(values_of(table));
        steps.push_back(steps_back(stamps.back()));
    }
    for (std::size_t i = 1; i < tables.size(); ++i)
        if (steps[i].size() != steps[0].size())
            return report_difference(
                tables[0], steps[0].size(), tables[i], steps[i].size(), findings);
    for (std::size_t k = 0; k < (steps.empty() ? 0 : steps[0].size()); ++k) {
        const std::int64_t by_ns = shift_ns(stamps, steps, k);
        for (std::size_t i = 0; i < tables.size(); ++i) move_rows(tables[i], steps[i][k], by_ns);
        findings.warning("clock_set_back",
                         tables[0].file,
                         "the clock was set back by " +
                             base::fixed(1e-9 * static_cast<double>(by_ns), 3) + " s before row " +
                             std::to_string(steps[0][k]) +
                             ": the order of the rows is believed, and the timestamps of all "
                             "sensors after it are moved forward by this time",
                         "Do not set the clock during a dive.");
    }
}

}  // namespace divemesh::dive
