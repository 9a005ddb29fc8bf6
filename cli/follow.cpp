#include "cli/follow.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>

#include "api/client/download.hpp"
#include "api/client/job_follower.hpp"
#include "cli/findings_text.hpp"
#include "cli/metrics_table.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"

namespace divemesh::cli {
namespace {

const Artifact& find_artifact(const std::vector<Artifact>& artifacts,
                              const std::string& job_id,
                              const std::string& name) {
    const auto found = std::find_if(
        artifacts.begin(), artifacts.end(), [&](const Artifact& a) { return a.name == name; });
    if (found == artifacts.end())
        throw Error(ErrorCode::NotFound,
                    "job " + job_id + " has no artifact " + name +
                        ": `divemesh download` without names lists all of them");
    return *found;
}

std::vector<Artifact> artifacts_of(api::client::RestClient& rest,
                                   const std::string& job_id,
                                   const std::vector<std::string>& names) {
    std::vector<Artifact> artifacts;
    for (const auto& item : rest.list(api::client::job_path(job_id) + "/artifacts", {}))
        artifacts.push_back(item.get<Artifact>());
    if (names.empty()) return artifacts;
    std::vector<Artifact> chosen;
    chosen.reserve(names.size());
    for (const auto& name : names) chosen.push_back(find_artifact(artifacts, job_id, name));
    return chosen;
}

void print_findings(api::client::RestClient& rest, const std::string& dive_id) {
    for (const auto& item : rest.list(api::client::dive_path(dive_id) + "/findings", {}))
        std::cerr << finding_text(item.get<Finding>());
}

}  // namespace

void show_progress(ProgressBar& bar, const Progress& progress) {
    std::string detail;
    std::array<char, 64> text{};
    if (progress.frames_per_s > 0.0) {
        std::snprintf(text.data(), text.size(), "%.1f frames/s", progress.frames_per_s);
        detail += text.data();
    }
    if (progress.seconds_left >= 0.0)
        detail += (detail.empty() ? "" : ", ") + duration_text(progress.seconds_left) + " left";
    bar.show(progress.stage, progress.fraction, detail);
}

api::client::BytesDone show_bytes(ProgressBar& bar, const std::string& label, std::int64_t total) {
    return [&bar, label, total, meter = TransferMeter()](std::int64_t done) mutable {
        const double fraction =
            total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1.0;
        bar.show(label, fraction, meter.detail(done, total));
    };
}

api::client::Backoff::OnWait say_waiting(ProgressBar& bar) {
    return [&bar](const Error& reason, std::chrono::milliseconds pause) {
        std::array<char, 48> text{};
        std::snprintf(text.data(),
                      text.size(),
                      "; trying again in %.1f s",
                      std::chrono::duration<double>(pause).count());
        bar.say(std::string(reason.what()) + text.data());
    };
}

Job wait_for_job(api::client::RestClient& rest, const std::string& job_id) {
    ProgressBar bar;
    return api::client::follow_job(
        rest,
        job_id,
        [&](const ShownJob& job) {
            if (job.state == JobState::Running && !job.progress.stage.empty())
                show_progress(bar, job.progress);
            else
                bar.show("job " + job.id + ": " + std::string(to_string(job.state)) +
                             (job.waits_for.empty() ? "" : ", waits for " + job.waits_for),
                         -1.0,
                         "");
        },
        say_waiting(bar));
}

Dive wait_for_dive(api::client::RestClient& rest, const std::string& dive_id) {
    Dive dive;
    {
        ProgressBar bar;
        bar.show("checking the dive", -1.0, "");
        dive = api::client::follow_dive(rest, dive_id, say_waiting(bar));
    }
    if (dive.state == DiveState::Refused) print_findings(rest, dive_id);
    return dive;
}

void download_job(api::client::RestClient& rest,
                  const std::string& job_id,
                  const std::vector<std::string>& names,
                  const std::filesystem::path& folder) {
    const auto artifacts = artifacts_of(rest, job_id, names);
    if (artifacts.empty())
        throw Error(ErrorCode::NotFound,
                    "job " + job_id + " has no artifacts: see `divemesh jobs " + job_id + "`");
    ProgressBar bar;
    TransferMeter meter;
    api::client::DownloadObserver observer;
    observer.on_wait = say_waiting(bar);
    observer.on_progress = [&](std::int64_t done, std::int64_t total) {
        bar.show("download",
                 total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1.0,
                 meter.detail(done, total));
    };
    api::client::download_artifacts(rest.account(), artifacts, folder, observer);
}

void print_job_metrics(api::client::RestClient& rest, const Job& job) {
    const auto artifacts = artifacts_of(rest, job.id, {});
    const bool has_metrics = std::any_of(
        artifacts.begin(), artifacts.end(), [](const auto& a) { return a.name == "metrics.json"; });
    if (has_metrics)
        std::cerr << metrics_summary(
            rest.get(api::client::job_path(job.id) + "/artifacts/metrics.json"));
    if (job.verdict) std::cerr << verdict_text(job.findings);
}

void print_failure(api::client::RestClient& rest, const Job& job) {
    if (job.verdict) std::cerr << verdict_text(job.findings);
    std::cerr << "job " << job.id << " " << to_string(job.state);
    if (!job.failure.message.empty()) std::cerr << ": " << job.failure.message;
    std::cerr << '\n';
    if (!job.failure.remedy.empty()) std::cerr << "  " << job.failure.remedy << '\n';
    const Dive dive = rest.get(api::client::dive_path(job.dive_id)).get<Dive>();
    if (dive.state == DiveState::Refused) print_findings(rest, job.dive_id);
}

bool fetch_results(api::client::RestClient& rest,
                   const std::string& job_id,
                   const std::filesystem::path& folder) {
    const Job job = wait_for_job(rest, job_id);
    const bool succeeded = job.state == JobState::Succeeded;
    if (succeeded)
        print_job_metrics(rest, job);
    else
        print_failure(rest, job);
    if (!folder.empty() && (succeeded || job.verdict)) download_job(rest, job_id, {}, folder);
    return succeeded;
}

}  // namespace divemesh::cli
