#include "storage/queue_forecast.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <tuple>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "schemas/wait_reason.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_speeds.hpp"
#include "storage/sql.hpp"
#include "storage/wait_reasons.hpp"

namespace divemesh::storage {
namespace {

using Seconds = std::optional<double>;  // nullopt: unknown, which a Forecast has as less than 0

struct WaitingRow {
    std::int64_t rank_ms = 0;
    std::string id;
    std::string project;
    std::string kind;
    std::string preset;
    std::int64_t num_frames = 0;
    std::int64_t archive_bytes = 0;
    std::int64_t not_before_ms = 0;
    std::string progress;

    void define(soci::statement& statement) {
        define_columns(statement,
                       rank_ms,
                       id,
                       project,
                       kind,
                       preset,
                       num_frames,
                       archive_bytes,
                       not_before_ms,
                       progress);
    }
    WaitingRow value() const { return *this; }
};

std::vector<WaitingRow> rows_in_state(soci::session& session, const std::string& state) {
    return select_all<WaitingRow>(
        session,
        "SELECT queue_rank_ms, jobs.id, jobs.project, kind, preset, num_frames, archive_bytes,"
        " not_before_ms, progress FROM jobs, dives WHERE jobs.state = '" +
            state + "' AND dives.id = dive_id ORDER BY queue_rank_ms, jobs.id");
}

Seconds takes_s(const JobSpeeds& speeds, const WaitingRow& row) {
    const auto speed = speeds.find({row.kind, row.preset});
    const auto num_units = row.kind == "intake" ? row.archive_bytes : row.num_frames;
    if (speed == speeds.end() || num_units <= 0) return std::nullopt;
    return speed->second * static_cast<double>(num_units);
}

std::vector<Seconds> running_left_s(soci::session& session, const JobSpeeds& speeds) {
    std::vector<Seconds> left_s;
    for (const WaitingRow& row : rows_in_state(session, "running")) {
        const auto progress = nlohmann::json::parse(row.progress).get<Progress>();
        left_s.push_back(progress.seconds_left >= 0.0 ? progress.seconds_left
                                                      : takes_s(speeds, row));
    }
    return left_s;
}

std::string reason_of(const WaitingRow& row, const WaitReasons& reasons) {
    Job job;
    job.project = row.project;
    job.kind = job_kind_from_string(row.kind);
    job.state = JobState::Queued;
    job.not_before_ms = row.not_before_ms;
    return reasons.of(job);
}

double rounded(Seconds seconds) {
    return seconds ? std::round(*seconds / 10) * 10 : Forecast{}.starts_in_s;
}

// Assigns the slots in order. Once a job of unknown duration has one, no later start is known.
class Slots {
public:
    Slots(int count, const std::vector<Seconds>& running_s) {
        known_ = count > 0;
        for (const Seconds& left_s : running_s) {
            known_ = known_ && left_s;
            free_at_s_.push(left_s.value_or(0.0));
        }
        while (free_at_s_.size() < static_cast<std::size_t>(count)) free_at_s_.push(0.0);
    }

    // Returns the start of a job that takes `for_s` and is not due before `due_s`.
    Seconds take(Seconds for_s, double due_s) {
        if (!known_) return std::nullopt;
        const double start_s = std::max(due_s, free_at_s_.top());
        free_at_s_.pop();
        free_at_s_.push(start_s + for_s.value_or(0.0));
        known_ = for_s.has_value();
        return start_s;
    }

private:
    bool known_ = false;
    std::priority_queue<double, std::vector<double>, std::greater<>> free_at_s_;
};

}  // namespace

// The queued jobs in the order in which they start, and what keeps jobs from starting.
struct QueueForecast::Snapshot {
    struct Place {
        std::int64_t rank_ms = 0;
        std::string id;
        Seconds starts_in_s = std::nullopt;
        Seconds takes_s = std::nullopt;
    };
    WaitReasons reasons;
    std::vector<Place> places;

    static std::shared_ptr<const Snapshot> taken_of(soci::session& session) {
        const JobSpeeds speeds = read_speeds(session);
        auto snapshot = std::make_shared<Snapshot>(Snapshot{WaitReasons(session), {}});
        const WaitReasons& reasons = snapshot->reasons;
        Slots slots(reasons.num_slots(), running_left_s(session, speeds));
        for (const WaitingRow& row : rows_in_state(session, "queued")) {
            Place place{.rank_ms = row.rank_ms, .id = row.id, .takes_s = takes_s(speeds, row)};
            const std::string reason = reason_of(row, reasons);
            const bool retried = reason == to_string(WaitReason::Retry);
            if (reason.empty() || retried)
                place.starts_in_s = slots.take(
                    place.takes_s,
                    retried ? static_cast<double>(row.not_before_ms - reasons.now_ms()) / 1000.0
                            : 0.0);
            snapshot->places.push_back(std::move(place));
        }
        return snapshot;
    }
};

QueueForecast::QueueForecast(std::chrono::milliseconds max_age) : max_age_(max_age) {}

QueueForecast::~QueueForecast() = default;

// One thread takes the new snapshot; the others use the old one meanwhile.
std::shared_ptr<const QueueForecast::Snapshot> QueueForecast::snapshot(Catalog& catalog) {
    using Clock = std::chrono::steady_clock;
    {
        const std::lock_guard lock(mutex_);
        if (newest_ && (being_taken_ || Clock::now() - taken_ < max_age_)) return newest_;
        if (!catalog.may_wait())
            throw Error(ErrorCode::Unavailable, "the forecast needs the queue to be read first");
        being_taken_ = true;
    }
    std::shared_ptr<const Snapshot> taken;
    try {
        catalog.read([&](soci::session& session) { taken = Snapshot::taken_of(session); });
    } catch (...) {
        const std::lock_guard lock(mutex_);
        being_taken_ = false;
        throw;
    }
    const std::lock_guard lock(mutex_);
    newest_ = taken;
    taken_ = Clock::now();
    being_taken_ = false;
    return taken;
}

std::optional<Forecast> QueueForecast::of(const Job& job, Catalog& catalog) {
    if (job.state != JobState::Queued) return std::nullopt;
    const auto now = snapshot(catalog);
    const std::int64_t rank_ms = queue_rank_ms(job.created_at_ms, job.priority);
    const auto at = std::lower_bound(
        now->places.begin(), now->places.end(), job, [&](const auto& place, const Job& wanted) {
            return std::tie(place.rank_ms, place.id) < std::tie(rank_ms, wanted.id);
        });
    Forecast forecast{.position = at - now->places.begin() + 1};
    if (at != now->places.end() && at->id == job.id) {
        forecast.starts_in_s = rounded(at->starts_in_s);
        forecast.takes_s = rounded(at->takes_s);
    }
    return forecast;
}

std::string QueueForecast::waits_for(const Job& job, Catalog& catalog) {
    if (job.state == JobState::Held) return reason_of_held(job);
    return job.state == JobState::Queued ? snapshot(catalog)->reasons.of(job) : "";
}

}  // namespace divemesh::storage
