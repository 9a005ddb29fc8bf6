#include "storage/stage_seconds.hpp"

#include <algorithm>
#include <cmath>

#include "storage/sql.hpp"

namespace divemesh::storage {
namespace {

constexpr double kBeyond = -1.0;

struct ClassRow {
    std::string stage;
    int cached = 0;
    double up_to_s = 0.0;
    std::int64_t num_runs = 0;
    double total_s = 0.0;

    void define(soci::statement& statement) {
        define_columns(statement, stage, cached, up_to_s, num_runs, total_s);
    }
    ClassRow value() const { return *this; }
};

std::size_t class_of(double up_to_s) {
    if (up_to_s == kBeyond) return kStageBounds_s.size();
    const auto* const bound =
        std::lower_bound(kStageBounds_s.begin(), kStageBounds_s.end(), up_to_s);
    return static_cast<std::size_t>(bound - kStageBounds_s.begin());
}

}  // namespace

void count_stage(soci::session& session, const StageRun& run) {
    const bool is_known =
        std::find(kStageNames.begin(), kStageNames.end(), run.name) != kStageNames.end();
    if (!is_known || !std::isfinite(run.seconds)) return;
    const double seconds = std::max(run.seconds, 0.0);
    const std::size_t its_class = class_of(seconds);
    const double up_to_s =
        its_class < kStageBounds_s.size() ? kStageBounds_s.at(its_class) : kBeyond;
    const int cached = run.from_cache ? 1 : 0;
    execute(session,
            "INSERT INTO stage_seconds (stage, cached, up_to_s, num_runs, total_s)"
            " VALUES (:stage, :cached, :bound, 1, :seconds)"
            " ON CONFLICT (stage, cached, up_to_s) DO UPDATE SET"
            " num_runs = stage_seconds.num_runs + 1,"
            " total_s = stage_seconds.total_s + excluded.total_s",
            soci::use(run.name, "stage"),
            soci::use(cached, "cached"),
            soci::use(up_to_s, "bound"),
            soci::use(seconds, "seconds"));
}

std::vector<StageSeconds> read_stage_seconds(soci::session& session) {
    std::vector<StageSeconds> stages;
    for (const ClassRow& row : select_all<ClassRow>(session,
                                                    "SELECT stage, cached, up_to_s, num_runs, "
                                                    "total_s FROM stage_seconds ORDER BY stage")) {
        if (stages.empty() || stages.back().stage != row.stage) stages.push_back({row.stage});
        StageSeconds& stage = stages.back();
        if (row.cached != 0) {
            stage.num_cached += row.num_runs;
        } else {
            stage.num_runs.at(class_of(row.up_to_s)) += row.num_runs;
            stage.total_s += row.total_s;
        }
    }
    return stages;
}

}  // namespace divemesh::storage
