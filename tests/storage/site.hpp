#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "storage/blob_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {

// A catalog and a blob store in a folder of their own, and the steps of the service on them.
struct Site : Stores {
    explicit Site(const std::filesystem::path& place)
        : Stores(catalog_url(place)),
          folder(place),
          blobs(open_blob_store((place / "blobs").string())) {
        for (const char* name : kArtifacts) std::ofstream(folder / name) << name;
    }

    void stage_upload() {
        const Upload upload = finished_upload();
        const auto staged = blobs->open_staged(upload.blob);
        staged->write(kRecording);
        staged->flush();
    }
    // What makes a dive of a finished upload, and what a restarted server does again.
    void commit() {
        for (const Upload& upload : uploads_.list_open()) {
            NewDive dive = request(upload, "wreck", "standard");
            dive.archive_sha256 = sha256_hex(kRecording);
            blobs->commit_staged(upload.blob, dive.blob);
            dives_.create(dive);
        }
    }

    // A reconstruction of a dive that is really there.
    void queue_job() {
        stage_upload();
        commit();
        finish_intake(dives_.list({}, {}).items.at(0));
    }

    Lease take() { return claim(std::chrono::minutes(5)).lease; }
    void publish(const Lease& lease) {
        std::vector<Artifact> artifacts;
        for (const char* name : kArtifacts) {
            const std::string key = "jobs/" + lease.job_id + "/" + lease.lease_id + "/" + name;
            blobs->put_file(key, folder / name);
            artifacts.push_back(
                {.name = name, .media_type = "x", .sha256 = sha256_hex(name), .blob = key});
        }
        EXPECT_TRUE(jobs_.succeed(lease, artifacts));
    }

    std::vector<Job> all_jobs() { return jobs_.list({}, {.limit = 200}).items; }
    JobState state_of_reconstruction() {
        for (const Job& job : all_jobs())
            if (job.kind == JobKind::Reconstruct) return job.state;
        throw std::runtime_error("the job is lost");
    }
    void lose_leases() {
        catalog_.transaction([](soci::session& session) {
            session << "UPDATE jobs SET lease_expires_at_ms = 0 WHERE state = 'running'";
        });
    }

    static constexpr std::string_view kRecording = "0123456789";
    static constexpr std::array kArtifacts = {"mesh.ply", "trajectory.tum"};

    std::filesystem::path folder;
    std::unique_ptr<BlobStore> blobs;
};

// Checks that catalog, blobs and events agree.
inline void expect_consistent(Site& site) {
    for (const Dive& dive : site.dives_.list({}, {}).items)
        EXPECT_TRUE(site.blobs->exists(dive.blob)) << dive.id;
    std::map<std::string, std::string> told;
    std::int64_t last = 0;
    for (const Event& event : site.events_.since(0, "", 1000)) {
        EXPECT_EQ(event.sequence, ++last);
        if (event.type == "job.state") told[event.subject] = event.data.at("state");
    }
    for (const Job& job : site.all_jobs()) {
        EXPECT_EQ(told[job.id], to_string(job.state)) << "what was told is not what is";
        const auto attempts = site.jobs_.attempts(job.id);
        const auto num_running = std::count_if(attempts.begin(), attempts.end(), [](auto& attempt) {
            return attempt.state == AttemptState::Running;
        });
        EXPECT_EQ(num_running, job.state == JobState::Running ? 1 : 0);
        const auto artifacts = site.jobs_.artifacts(job.id);
        const bool published = job.kind == JobKind::Reconstruct && job.state == JobState::Succeeded;
        EXPECT_EQ(artifacts.size(), published ? 2U : 0U);
        for (const Artifact& artifact : artifacts) EXPECT_TRUE(site.blobs->exists(artifact.blob));
    }
}

}  // namespace divemesh::storage
