#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <sys/types.h>

#include "schemas/content_hash.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_store.hpp"
#include "storage/truth_store.hpp"
#include "storage/upload_store.hpp"
#include "tests/end_to_end/process.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::runner {

// A test with real worker processes, parent and child, and a fake pipeline.
class JobRunnerTest : public testing::Test {
protected:
    Process start_worker(const std::string& deadline_ms = "600000",
                         const std::string& file_limit_bytes = "1000000000",
                         const std::string& scratch_bytes = "1000000000",
                         const std::string& min_free_bytes = "0") {
        const std::filesystem::path output = folder_ / ("worker-" + std::to_string(++num_workers_));
        std::filesystem::create_directories(output);
        return Process({FAKE_WORKER,
                        "worker",
                        catalog_url_,
                        (folder_ / "blobs").string(),
                        work_folder_.string(),
                        "2000",
                        deadline_ms,
                        file_limit_bytes,
                        scratch_bytes,
                        min_free_bytes},
                       output);
    }

    // Creates a job for a dive. The fake pipeline runs `script` as its reconstruction.
    Job make_job(const std::string& script, int max_attempts = 3) {
        std::ofstream(folder_ / "archive") << script;
        const Upload upload = uploads_.create({.project = "default", .length_bytes = 0});
        const std::string key = "dives/" + upload.id + "/archive";
        blobs_->put_file(key, folder_ / "archive");
        const Dive dive = dives_
                              .create({.upload_id = upload.id,
                                       .project = "default",
                                       .archive_sha256 = sha256_hex(script),
                                       .blob = key})
                              .dive;
        return jobs_
            .enqueue({.dive_id = dive.id, .preset = "standard", .max_attempts = max_attempts})
            .job;
    }

    bool reaches(const Job& job, JobState state) {
        return wait_until(std::chrono::seconds(60),
                          [&] { return jobs_.get(job.id).state == state; });
    }
    // Returns whether an attempt fails and leaves the job in the queue with all its attempts.
    bool fails_without_counting(const Job& job) {
        return wait_until(std::chrono::seconds(60), [&] {
            const auto attempts = jobs_.attempts(job.id);
            const Job now = jobs_.get(job.id);
            return !attempts.empty() && attempts.front().state == AttemptState::Failed &&
                   now.state == JobState::Queued && now.num_attempts == 0;
        });
    }
    pid_t child_of_marker() {
        EXPECT_TRUE(
            wait_until(std::chrono::seconds(60), [&] { return std::filesystem::exists(marker_); }));
        pid_t pid = 0;
        std::ifstream(marker_) >> pid;
        return pid;
    }
    static std::string state_of(pid_t pid) {
        std::string line;
        std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
        std::getline(stat, line);
        return line.empty() ? "" : line.substr(line.rfind(')') + 2, 1);
    }
    static bool is_gone(pid_t pid) {
        return wait_until(std::chrono::seconds(10), [&] {
            const std::string state = state_of(pid);
            return state.empty() || state == "Z";
        });
    }
    // Stops the worker outside its own transactions. Within one, SQLite would block all other
    // writers until the worker continues.
    void freeze(Process& worker) {
        catalog_.transaction([&](soci::session&) {
            worker.send(SIGSTOP);
            EXPECT_TRUE(wait_until(std::chrono::seconds(10),
                                   [&] { return state_of(worker.pid()) == "T"; }));
        });
    }
    std::size_t num_blobs_of_jobs() const {
        std::size_t count = 0;
        if (!std::filesystem::exists(folder_ / "blobs/blobs/jobs")) return 0;
        for (const auto& entry :
             std::filesystem::recursive_directory_iterator(folder_ / "blobs/blobs/jobs"))
            count += entry.is_regular_file() && entry.path().filename() != "thumbnail.jpg";
        return count;
    }
    std::string wait_once() const { return "wait-once " + marker_.string(); }
    void let_go() const { std::ofstream(marker_.string() + ".go") << "go"; }

    TruthFile add_truth(const Job& of, const std::string& name, const std::string& content) {
        std::ofstream(folder_ / "truth") << content;
        const Upload upload = uploads_.create({.project = "default", .length_bytes = 0});
        const std::string key = "truth/" + upload.id + "/file";
        blobs_->put_file(key, folder_ / "truth");
        return storage::TruthStore(catalog_)
            .create({.upload_id = upload.id,
                     .project = "default",
                     .dive_id = of.dive_id,
                     .name = name,
                     .sha256 = sha256_hex(content),
                     .size_bytes = static_cast<std::int64_t>(content.size()),
                     .blob = key})
            .file;
    }
    std::string content_of(const Artifact& artifact) {
        const auto blob = blobs_->open(artifact.blob);
        std::string text(static_cast<std::size_t>(blob->size_bytes()), ' ');
        blob->read_at(0, text);
        return text;
    }

    TemporaryFolder folder_;
    std::filesystem::path marker_ = folder_ / "marker";
    std::filesystem::path work_folder_ = folder_ / "work";  // the cache is beside it
    std::string catalog_url_ = "sqlite://" + (folder_ / "catalog.db").string();
    storage::Catalog catalog_{catalog_url_};
    storage::UploadStore uploads_{catalog_};
    storage::DiveStore dives_{catalog_};
    storage::JobStore jobs_{catalog_};
    std::unique_ptr<storage::BlobStore> blobs_ =
        storage::open_blob_store((folder_ / "blobs").string());
    int num_workers_ = 0;
};

}  // namespace divemesh::runner
