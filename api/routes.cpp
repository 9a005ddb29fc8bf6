#include "api/routes.hpp"

#include <algorithm>

#include "api/handlers/artifacts.hpp"
#include "api/handlers/commands.hpp"
#include "api/handlers/dive_edits.hpp"
#include "api/handlers/dive_removal.hpp"
#include "api/handlers/dives.hpp"
#include "api/handlers/events.hpp"
#include "api/handlers/health.hpp"
#include "api/handlers/info.hpp"
#include "api/handlers/jobs.hpp"
#include "api/handlers/metric_series.hpp"
#include "api/handlers/metrics.hpp"
#include "api/handlers/page.hpp"
#include "api/handlers/previews.hpp"
#include "api/handlers/queue.hpp"
#include "api/handlers/result_removal.hpp"
#include "api/handlers/schedules.hpp"
#include "api/handlers/sensors.hpp"
#include "api/handlers/sessions.hpp"
#include "api/handlers/shares.hpp"
#include "api/handlers/tokens.hpp"
#include "api/handlers/truth.hpp"
#include "api/handlers/uploads.hpp"
#include "api/handlers/webhooks.hpp"

namespace divemesh::api {
namespace {

using enum RouteKind;

// The whole API, and behind it the addresses of the web page. api/openapi.yaml lists the routes of
// the API; a test keeps them equal.
constexpr Route kRoutes[] = {
    // clang-format off
    {Plain,      verb::options, "/api/v1/uploads",                "",            describe_uploads},
    {BodyStream, verb::post,    "/api/v1/uploads",                "dives:write", create_upload},
    {Plain,      verb::options, "/api/v1/uploads/{upload_id}",    "",            describe_uploads},
    {Plain,      verb::head,    "/api/v1/uploads/{upload_id}",    "dives:write", get_upload_offset},
    {Plain,      verb::get,     "/api/v1/uploads/{upload_id}",    "dives:write", get_upload},
    {BodyStream, verb::patch,   "/api/v1/uploads/{upload_id}",    "dives:write", append_to_upload},
    {Plain,      verb::delete_, "/api/v1/uploads/{upload_id}",    "dives:write", terminate_upload},

    {Plain,      verb::get,     "/api/v1/dives",                  "dives:read",  list_dives},
    {Plain,      verb::post,    "/api/v1/dives",                  "dives:write", create_dive},
    {Plain,      verb::get,     "/api/v1/dives/{dive_id}",        "dives:read",  get_dive},
    {Plain,      verb::patch,   "/api/v1/dives/{dive_id}",        "dives:write", edit_dive},
    {Plain,      verb::delete_, "/api/v1/dives/{dive_id}",        "dives:write", delete_dive},
    {Plain,      verb::post,    "/api/v1/dives/{dive_id}/restore",       "dives:write", restore_dive},
    {Plain,      verb::get,     "/api/v1/dives/{dive_id}/findings",      "dives:read", list_findings},
    {File,       verb::get,     "/api/v1/dives/{dive_id}/thumbnail.jpg", "dives:read", get_thumbnail},
    {Plain,      verb::post,    "/api/v1/dives/{dive_id}/jobs",   "jobs:write",  create_job},
    {Plain,      verb::get,     "/api/v1/dives/{dive_id}/truth",  "dives:read",  list_truth},
    {Plain,      verb::get,     "/api/v1/dives/{dive_id}/truth/{truth_id}", "dives:read",  get_truth},
    {Plain,      verb::delete_, "/api/v1/dives/{dive_id}/truth/{truth_id}", "dives:write", delete_truth},
    {File,       verb::get,     "/api/v1/dives/{dive_id}/truth/{truth_id}/content", "dives:read", get_truth_content},

    {Plain,      verb::get,     "/api/v1/metrics",                "dives:read",  get_metric_series},
    {Plain,      verb::get,     "/api/v1/metrics/names",          "dives:read",  list_metrics},
    {Plain,      verb::get,     "/api/v1/schedules",              "dives:read",  list_schedules},
    {Plain,      verb::post,    "/api/v1/schedules",              "jobs:write",  create_schedule},
    {Plain,      verb::get,     "/api/v1/schedules/{schedule_id}", "dives:read", get_schedule},
    {Plain,      verb::delete_, "/api/v1/schedules/{schedule_id}", "jobs:write", delete_schedule},

    {Plain,      verb::get,     "/api/v1/jobs",                   "dives:read",  list_jobs},
    {Plain,      verb::get,     "/api/v1/jobs/{job_id}",          "dives:read",  get_job},
    {Plain,      verb::patch,   "/api/v1/jobs/{job_id}",          "jobs:write",  change_job},
    {Plain,      verb::delete_, "/api/v1/jobs/{job_id}",          "jobs:write",  delete_job},
    {Plain,      verb::post,    "/api/v1/jobs/{job_id}/restore",  "jobs:write",  restore_job},
    {Plain,      verb::post,    "/api/v1/jobs/{job_id}/cancel",   "jobs:write",  cancel_job},
    {Plain,      verb::post,    "/api/v1/jobs/{job_id}/retry",    "jobs:write",  retry_job},
    {Plain,      verb::get,     "/api/v1/jobs/{job_id}/log",      "dives:read",  get_job_log},
    {Plain,      verb::get,     "/api/v1/jobs/{job_id}/attempts", "dives:read",  list_attempts},
    {Plain,      verb::get,     "/api/v1/jobs/{job_id}/attempts/{attempt}/log",
                                                                  "dives:read",  get_attempt_log},
    {File,       verb::get,     "/api/v1/jobs/{job_id}/artifacts.zip", "dives:read", get_artifacts_archive},
    {Plain,      verb::get,     "/api/v1/jobs/{job_id}/artifacts", "dives:read", list_artifacts},
    {File,       verb::get,     "/api/v1/jobs/{job_id}/artifacts/{artifact_name...}",
                                                                  "dives:read",  get_artifact},
    {Plain,      verb::get,     "/api/v1/jobs/{job_id}/shares",   "dives:read",  list_shares},
    {Secret,     verb::post,    "/api/v1/jobs/{job_id}/shares",   "jobs:write",  create_share},
    {Plain,      verb::delete_, "/api/v1/jobs/{job_id}/shares/{share_id}", "jobs:write", withdraw_share},

    {Plain,      verb::get,     "/api/v1/queue",                  "dives:read",  get_queue},
    {Plain,      verb::patch,   "/api/v1/queue",                  "admin",       change_queue},
    {Plain,      verb::post,    "/api/v1/queue/redrive",          "jobs:write",  redrive_queue},
    {Plain,      verb::get,     "/api/v1/usage",                  "dives:read",  get_usage},
    {Plain,      verb::get,     "/api/v1/workers",                "admin",       list_workers},
    {Plain,      verb::get,     "/api/v1/workers/{worker_name}",  "admin",       get_worker},
    {Plain,      verb::patch,   "/api/v1/workers/{worker_name}",  "admin",       change_worker},

    {Plain,      verb::get,     "/api/v1/sensors",                "dives:read",  list_sensors},
    {Plain,      verb::get,     "/api/v1/sensors/{sensor_id}",    "dives:read",  get_sensor},
    {Plain,      verb::get,     "/api/v1/sensors/{sensor_id}/history", "dives:read", get_sensor_history},
    {Plain,      verb::post,    "/api/v1/sensors/{sensor_id}/status", "sensor:push", push_sensor_status},
    {WebSocket,  verb::get,     "/api/v1/sensors/{sensor_id}/stream", "sensor:push", open_sensor_stream},
    {File,       verb::get,     "/api/v1/sensors/{sensor_id}/preview.jpg", "dives:read", get_newest_preview},
    {Plain,      verb::get,     "/api/v1/sensors/{sensor_id}/previews", "dives:read", list_previews},
    {File,       verb::get,     "/api/v1/sensors/{sensor_id}/previews/{preview_id}", "dives:read", get_preview},
    {Plain,      verb::get,     "/api/v1/sensors/{sensor_id}/commands", "dives:read", list_commands},
    {Plain,      verb::post,    "/api/v1/sensors/{sensor_id}/commands", "sensor:command", create_command},
    {Plain,      verb::get,     "/api/v1/sensors/{sensor_id}/commands/{command_id}", "dives:read", get_command},

    {Plain,      verb::get,     "/api/v1/info",                   "dives:read",  get_info},
    {Plain,      verb::get,     "/api/v1/options",                "dives:read",  get_options},
    {WebSocket,  verb::get,     "/api/v1/events",                 "dives:read",  watch_events},

    {Plain,      verb::get,     "/api/v1/tokens",                 "admin",       list_tokens},
    {Secret,     verb::post,    "/api/v1/tokens",                 "admin",       create_token},
    {Plain,      verb::delete_, "/api/v1/tokens/{token_id}",      "admin",       revoke_token},
    {Secret,     verb::post,    "/api/v1/one_shot_tokens",        "dives:read",  create_one_shot_token},
    {Plain,      verb::get,     "/api/v1/session",                kAnyToken,     get_session},
    {Secret,     verb::post,    "/api/v1/session",                kAnyToken,     create_session},
    {Plain,      verb::delete_, "/api/v1/session",                kAnyToken,     end_session},

    {Plain,      verb::get,     "/api/v1/webhooks",               "admin",       list_webhooks},
    {Secret,     verb::post,    "/api/v1/webhooks",               "admin",       create_webhook},
    {Plain,      verb::delete_, "/api/v1/webhooks/{webhook_id}",  "admin",       delete_webhook},
    {Plain,      verb::post,    "/api/v1/webhooks/{webhook_id}/enable",     "admin", enable_webhook},
    {Plain,      verb::get,     "/api/v1/webhooks/{webhook_id}/deliveries", "admin", list_webhook_deliveries},
    {Plain,      verb::post,    "/api/v1/webhooks/{webhook_id}/deliveries/{delivery_id}/redeliver",
                                                                  "admin",       redeliver_webhook},

    {Plain,      verb::get,     "/healthz/live",                  "",            get_liveness},
    {Plain,      verb::get,     "/healthz/ready",                 "",            get_readiness},
    {Plain,      verb::get,     "/metrics",                       "metrics:read", get_metrics},
    {Plain,      verb::get,     "/openapi.json",                  "",            get_openapi},

    // Each of these shows the page, which finds in the address what to show.
    {Page,       verb::get,     "/",                              "",            show_page},
    {Page,       verb::get,     "/sign-in",                       "",            show_page},
    {Page,       verb::get,     "/dives",                         "",            show_page},
    {Page,       verb::get,     "/dives/{view...}",               "",            show_page},
    {Page,       verb::get,     "/jobs",                          "",            show_page},
    {Page,       verb::get,     "/jobs/{view...}",                "",            show_page},
    {Page,       verb::get,     "/compare",                       "",            show_page},
    {Page,       verb::get,     "/compare/{view...}",             "",            show_page},
    {Page,       verb::get,     "/accuracy",                      "",            show_page},
    {Page,       verb::get,     "/sensors",                       "",            show_page},
    {Page,       verb::get,     "/sensors/{view...}",             "",            show_page},
    {Page,       verb::get,     "/share",                         "",            show_share},
    {Page,       verb::get,     "/share.js",                      "",            get_plain_share_script},
    {Page,       verb::get,     "/settings",                      "",            show_page},
    {Page,       verb::get,     "/admin",                         "",            show_page},
    {Page,       verb::get,     "/admin/{view...}",               "",            show_page},
    {Page,       verb::get,     "/embed",                         "",            show_page_in_frame},
    {Page,       verb::get,     "/embed/{view...}",               "",            show_page_in_frame},
    {Page,       verb::get,     "/assets/{asset_name}",           "",            get_page_asset},
    // clang-format on
};

}  // namespace

std::span<const Route> routes() { return kRoutes; }

std::span<const Route> api_routes() {
    const auto is_page = [](const Route& route) { return route.kind == Page; };
    return {std::begin(kRoutes), std::find_if(std::begin(kRoutes), std::end(kRoutes), is_page)};
}

}  // namespace divemesh::api
