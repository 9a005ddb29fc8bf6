#include "tests/end_to_end/queue_storm.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <thread>

#include "api/client/http_connection.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_store.hpp"
#include "storage/upload_store.hpp"
#include "tests/end_to_end/process.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class Storm {
public:
    explicit Storm(const QueueStorm& settings) : settings_(settings), random_(settings.seed) {
        fs::create_directories(folder_ / "logs");
        make_dive();
        start_server();
        workers_.resize(static_cast<std::size_t>(settings_.num_workers));
        for (auto& worker : workers_) start(worker);
    }

    StormReport run() {
        const auto begun = Clock::now();
        std::jthread asker([this](const std::stop_token& stop) { ask_for_jobs(stop); });
        kill_until_done();
        asker.request_stop();
        asker.join();
        end_all();
        report_.seconds = std::chrono::duration<double>(Clock::now() - begun).count();
        check();
        return report_;
    }

private:
    void make_dive() {
        std::ofstream(folder_ / "archive") << "empty";
        const Upload upload =
            storage::UploadStore(catalog_).create({.project = "default", .length_bytes = 0});
        const std::string key = "dives/" + upload.id + "/archive";
        blobs_->put_file(key, folder_ / "archive");
        dive_id_ = storage::DiveStore(catalog_)
                       .create({.upload_id = upload.id,
                                .project = "default",
                                .archive_sha256 = sha256_hex("empty"),
                                .blob = key})
                       .dive.id;
    }

    void start_server() {
        server_.reset();
        const std::string listen = "127.0.0.1:" + (port_.empty() ? "0" : port_);
        server_.emplace(std::vector<std::string>{settings_.program.string(),
                                                 "serve",
                                                 "--data",
                                                 folder_.path().string(),
                                                 "--catalog",
                                                 catalog_url_,
                                                 "--listen",
                                                 listen,
                                                 "--workers",
                                                 "0",
                                                 "--no-auth"},
                        folder_ / "logs");
        if (!port_.empty()) return;
        wait_until(60s, [&] {
            const std::string text = server_->stdout_text();
            const auto end = text.find('\n');
            if (end != std::string::npos) port_ = text.substr(0, end);
            return !port_.empty();
        });
        port_ = port_.substr(port_.rfind(':') + 1);
    }

    void start(std::optional<Process>& worker) {
        worker.reset();
        worker.emplace(std::vector<std::string>{settings_.fake_worker.string(),
                                                "worker",
                                                catalog_url_,
                                                (folder_ / "blobs").string(),
                                                (folder_ / "work").string(),
                                                "2000",
                                                "600000",
                                                "1000000000",
                                                "1000000000",
                                                "0"},
                       folder_ / "logs");
    }

    // Each until the server has said yes, however often it is killed meanwhile.
    void ask_for_jobs(const std::stop_token& stop) {
        api::client::HttpConnection server(
            api::client::parse_server_url("http://127.0.0.1:" + port_), 5s);
        for (int i = 0; i < settings_.num_jobs && !stop.stop_requested();) {
            const nlohmann::json body = {{"options", {{"seed", i + 1}}}};
            try {
                const auto answer =
                    server.send({"POST",
                                 "/api/v1/dives/" + dive_id_ + "/jobs",
                                 {{"Content-Type", "application/json"},
                                  {"Idempotency-Key", "storm-" + std::to_string(i)}},
                                 body.dump()});
                if (answer.status == 200 || answer.status == 201) {
                    const std::lock_guard lock(mutex_);
                    promised_.push_back(nlohmann::json::parse(answer.body).at("id"));
                    ++i;
                    continue;
                }
            } catch (const Error&) {  // killed: its successor is asked again
            }
            std::this_thread::sleep_for(20ms);
        }
    }

    // Jobs that were hit three times in a row are dead: a person puts them back.
    int num_finished() {
        int finished = -1;  // less the intake
        for (const auto& [state, count] : jobs_.count_by_state()) {
            if (state == JobState::Dead)
                report_.num_redriven += static_cast<int>(jobs_.redrive("", 1000).size());
            else if (is_finished(state))
                finished += static_cast<int>(count);
        }
        return finished;
    }

    // Evenly spread over the jobs as they get done.
    void kill_until_done() {
        auto moved = Clock::now();
        for (int before = 0, done = 0; done < settings_.num_jobs; before = done) {
            std::this_thread::sleep_for(10ms);
            done = std::max(0, num_finished());
            if (done != before) moved = Clock::now();
            if (Clock::now() - moved > 60s) return;
            if (report_.num_kills < settings_.num_kills &&
                done >= (report_.num_kills + 1) * settings_.num_jobs / (settings_.num_kills + 1))
                kill_one();
        }
    }

    void kill_one() {
        const std::size_t num_victims = workers_.size() + (settings_.kill_database ? 2 : 1);
        const auto victim = std::uniform_int_distribution<std::size_t>(0, num_victims - 1)(random_);
        if (victim == workers_.size()) {
            server_->kill();
            start_server();
        } else if (victim > workers_.size()) {
            settings_.kill_database();
            ++report_.num_database_kills;
        } else {
            workers_[victim]->kill();
            start(workers_[victim]);
        }
        ++report_.num_kills;
    }

    void end_all() {
        for (auto& worker : workers_) worker->send(SIGTERM);
        for (auto& worker : workers_)
            if (worker->wait(30s) != 0) complain("a worker did not end: " + worker->stderr_text());
        server_->send(SIGTERM);
        if (server_->wait(30s) != 0) complain("the server did not end: " + server_->stderr_text());
    }

    void check() {
        std::map<std::string, int> jobs_by_work;
        std::map<std::string, bool> known;
        storage::PageRequest page{.limit = 200};
        do {
            const auto part = jobs_.list({.kind = JobKind::Reconstruct}, page);
            for (const Job& job : part.items) {
                ++jobs_by_work[job.options.dump()];
                known[job.id] = true;
                check_job(job);
            }
            page.cursor = part.next_cursor;
        } while (!page.cursor.empty());
        for (const std::string& id : promised_)
            if (!known.contains(id)) complain("job " + id + " was promised and is lost");
        if (std::ssize(promised_) != settings_.num_jobs)
            complain("only " + std::to_string(promised_.size()) + " jobs were promised");
        for (const auto& [work, count] : jobs_by_work)
            if (count != 1) complain(work + " became " + std::to_string(count) + " jobs");
    }

    // One success, and what is visible is its alone.
    void check_job(const Job& job) {
        const auto attempts = jobs_.attempts(job.id);
        report_.num_attempts += static_cast<int>(attempts.size());
        int winner = 0;
        int num_successes = 0;
        for (const Attempt& attempt : attempts) {
            if (attempt.state == AttemptState::Running) complain(job.id + " has a running attempt");
            if (attempt.state != AttemptState::Succeeded) continue;
            winner = attempt.number;
            ++num_successes;
        }
        if (job.state != JobState::Succeeded || num_successes != 1)
            return complain("job " + job.id + " is " + std::string(to_string(job.state)) +
                            " after " + std::to_string(num_successes) +
                            " successes: " + job.failure.message);
        ++report_.num_succeeded;
        const auto artifacts = jobs_.artifacts(job.id);
        if (artifacts.size() != 1) return complain("job " + job.id + " has not one artifact");
        const std::string& blob = artifacts[0].blob;
        if (blob.find("/attempt-" + std::to_string(winner) + "-") == std::string::npos)
            complain("job " + job.id + " shows " + blob + ", not of attempt " +
                     std::to_string(winner));
        if (!blobs_->exists(blob)) complain("there is no " + blob);
    }

    void complain(const std::string& text) { report_.complaints.push_back(text); }

    QueueStorm settings_;
    std::mt19937 random_;
    TemporaryFolder folder_;
    std::string catalog_url_ = settings_.catalog_url.empty()
                                   ? "sqlite://" + (folder_ / "catalog.db").string()
                                   : settings_.catalog_url;
    storage::Catalog catalog_{catalog_url_};
    storage::JobStore jobs_{catalog_};
    std::unique_ptr<storage::BlobStore> blobs_ =
        storage::open_blob_store((folder_ / "blobs").string());
    std::string dive_id_;
    std::string port_;
    std::optional<Process> server_;
    std::vector<std::optional<Process>> workers_;
    std::mutex mutex_;
    std::vector<std::string> promised_;
    StormReport report_;
};

}  // namespace

StormReport run_queue_storm(const QueueStorm& storm) { return Storm(storm).run(); }

}  // namespace divemesh
