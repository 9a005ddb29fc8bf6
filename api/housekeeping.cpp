#include "api/housekeeping.hpp"

#include <nlohmann/json.hpp>

#include "api/audit.hpp"
#include "api/disk_guard.hpp"
#include "api/disk_reserve.hpp"
#include "api/sensors/sensor_hub.hpp"
#include "api/uploads/make_truth.hpp"
#include "schemas/log.hpp"
#include "storage/browser_session_store.hpp"
#include "storage/dive_removal.hpp"
#include "storage/job_store.hpp"
#include "storage/leftovers.hpp"
#include "storage/result_removal.hpp"
#include "storage/schedule_store.hpp"
#include "storage/sensor_store.hpp"
#include "storage/webhook_store.hpp"
#include "storage/worker_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::chrono::hours kLeftoversKept{1};
constexpr std::chrono::hours kEventsKept{24 * 90};
constexpr std::chrono::hours kDeliveriesKept{24 * 30};
constexpr std::chrono::hours kSensorHistoryKept{24 * 366};
constexpr int kPerRound = 100;

}  // namespace

void remove_expired_dives(const Services& services) {
    storage::DiveRemoval removal(services.catalog);
    for (const Dive& dive : removal.expired(kPerRound)) {
        for (const std::string& prefix : removal.blob_prefixes(dive))
            services.blobs.remove_prefix(prefix);
        removal.forget(dive.id);
    }
}

void remove_expired_results(const Services& services) {
    storage::ResultRemoval removal(services.catalog);
    for (const std::string& job_id : removal.expired(kPerRound)) {
        for (const std::string& prefix : removal.blob_prefixes(job_id))
            services.blobs.remove_prefix(prefix);
        removal.forget(job_id);
    }
}

namespace {

template <typename Task>
void attempt(const char* task_name, const Services& services, const Task& task) {
    if (services.stopping) return;
    try {
        task();
    } catch (const std::exception& error) {
        log_warning({{"event", "cleaning_failed"}, {"task", task_name}, {"what", error.what()}});
    }
}

// Takes the write lock anew for each round, so that nobody waits for long.
void remove_old_results(const Services& services) {
    storage::ResultRemoval removal(services.catalog);
    const auto audit = [](soci::session& session, const std::string& job_id) {
        append_audit_event(session, "keep_results", "deleted the result of job " + job_id);
    };
    while (!services.stopping &&
           removal.remove_old(services.limits.keep_deleted, kPerRound, audit) == kPerRound) {
    }
}

}  // namespace

void clean_up(const Services& services) {
    auto& catalog = services.catalog;
    attempt("reserve", services, [&] {
        reachable_bytes(services, services.limits.min_free_bytes + DiskReserve::kBytes);
        services.reserve.hold(services.limits.min_free_bytes);
    });
    attempt("dives", services, [&] { remove_expired_dives(services); });
    attempt("results", services, [&] {
        remove_old_results(services);
        remove_expired_results(services);
    });
    attempt("truth", services, [&] { remove_deleted_truth(services); });
    attempt("attempts", services, [&] {
        storage::remove_leftovers(catalog, services.blobs, kLeftoversKept, kPerRound);
    });
    attempt("events", services, [&] { storage::forget_events(catalog, kEventsKept); });
    attempt("sessions", services, [&] { storage::BrowserSessionStore(catalog).forget_ended(); });
    attempt("sensors", services, [&] {
        storage::SensorStore sensors(catalog);
        while (!services.stopping && !sensors.forget_older_than(kSensorHistoryKept)) {
        }
    });
    attempt("webhooks", services, [&] {
        storage::WebhookStore(catalog).forget_older_than(kDeliveriesKept);
    });
}

void watch_sensors(const Services& services) {
    attempt("sensors' silence", services, [&] {
        for (const Sensor& sensor : storage::SensorStore(services.catalog).look_at_the_time())
            services.sensor_hub.publish(sensor);
        services.sensor_hub.look_at_the_time();
    });
}

void run_schedules(const Services& services) {
    const auto note = [](soci::session& session, const Schedule& schedule, int num_jobs) {
        append_audit_event(session,
                           "schedule " + schedule.id,
                           std::to_string(num_jobs) + " reports of the tag " + schedule.tag +
                               " in project " + schedule.project);
    };
    attempt("schedules", services, [&] {
        storage::ScheduleStore(services.catalog)
            .run_due(DIVEMESH_VERSION, note, services.limits.max_project_bytes);
    });
}

void end_lost_leases(const Services& services) {
    attempt("leases", services, [&] { storage::JobStore(services.catalog).requeue_expired(); });
    attempt("lost workers", services, [&] {
        storage::WorkerStore(services.catalog).forget_silent(services.limits.keep_lost_workers);
    });
}

}  // namespace divemesh::api
