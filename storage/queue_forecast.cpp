#include "storage/queue_forecast.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <set>
#include <tuple>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_speeds.hpp"
#include "storage/sql.hpp"
#include "storage/worker_store.hpp"

namespace divemesh::storage {
namespace {

constexpr double kUnknown = -1.0;

struct WaitingRow {
    std::int64_t rank_ms = 0;
    std::string id;
    std::string project;
    std::string kind;
    std::string preset;
    std::int64_t num_frames = 0;
    std::int64_t archive_bytes = 0;
    std::string progress;

    void define(soci::statement& statement) {
        define_columns(
            statement, rank_ms, id, project, kind, preset, num_frames, archive_bytes, progress);
    }
    WaitingRow value() const { return *this; }
};

std::vector<WaitingRow> rows_in_state(soci::session& session, const std::string& state) {
    return select_all<WaitingRow>(
        session,
        "SELECT queue_rank_ms, jobs.id, jobs.project, kind, preset, num_frames, archive_bytes,"
        " progress FROM jobs, dives WHERE jobs.state = '" +
            state + "' AND dives.id = dive_id ORDER BY queue_rank_ms, jobs.id");
}

double takes_s(const JobSpeeds& speeds, const WaitingRow& row) {
    const auto speed = speeds.find({row.kind, row.preset});
    const auto num_units = row.kind == "intake" ? row.archive_bytes : row.num_frames;
    if (speed == speeds.end() || num_units <= 0) return kUnknown;
    return speed->second * static_cast<double>(num_units);
}

std::set<std::string> paused_projects(soci::session& session) {
    const auto names = select_all<TextRow>(session, "SELECT project FROM queues WHERE paused = 1");
    return {names.begin(), names.end()};
}

int num_slots(soci::session& session) {
    const std::int64_t alive_since_ms = Catalog::now_ms(session) - kWorkerSilence_ms;
    int slots = 0;
    session << "SELECT COALESCE(SUM(num_slots), 0) FROM workers"
               " WHERE draining = 0 AND seen_at_ms >= :alive",
        soci::use(alive_since_ms, "alive"), soci::into(slots);
    return slots;
}

double rounded(double seconds) { return seconds < 0.0 ? kUnknown : std::round(seconds / 10) * 10; }

// Assigns the slots in order. Once a job of unknown duration has one, no later start is known.
class Slots {
public:
    Slots(int count, const std::vector<double>& running_s) {
        known_ = count > 0;
        for (const double left_s : running_s) {
            known_ = known_ && left_s >= 0.0;
            free_at_s_.push(left_s);
        }
        while (free_at_s_.size() < static_cast<std::size_t>(count)) free_at_s_.push(0.0);
    }

    double take(double for_s) {
        if (!known_) return kUnknown;
        const double start_s = free_at_s_.top();
        free_at_s_.pop();
        free_at_s_.push(start_s + for_s);
        known_ = for_s >= 0.0;
        return start_s;
    }

private:
    bool known_ = false;
    std::priority_queue<double, std::vector<double>, std::greater<>> free_at_s_;
};

}  // namespace

// The queued jobs in the order in which they start.
struct QueueForecast::Snapshot {
    struct Place {
        std::int64_t rank_ms = 0;
        std::string id;
        double starts_in_s = kUnknown;
        double takes_s = kUnknown;
    };
    std::vector<Place> places;

    static std::shared_ptr<const Snapshot> taken_of(soci::session& session) {
        const JobSpeeds speeds = read_speeds(session);
        const auto paused = paused_projects(session);
        std::vector<double> running_s;
        for (const WaitingRow& row : rows_in_state(session, "running")) {
            const auto progress = nlohmann::json::parse(row.progress).get<Progress>();
            running_s.push_back(progress.seconds_left >= 0.0 ? progress.seconds_left
                                                             : takes_s(speeds, row));
        }
        Slots slots(paused.contains("") ? 0 : num_slots(session), running_s);
        auto snapshot = std::make_shared<Snapshot>();
        for (const WaitingRow& row : rows_in_state(session, "queued")) {
            Place place{.rank_ms = row.rank_ms, .id = row.id, .takes_s = takes_s(speeds, row)};
            if (!paused.contains(row.project)) place.starts_in_s = slots.take(place.takes_s);
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

}  // namespace divemesh::storage
