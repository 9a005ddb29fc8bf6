#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <optional>
#include <soci/soci.h>
#include <string>
#include <unistd.h>

#include "schemas/content_hash.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "storage/event_store.hpp"
#include "storage/job_store.hpp"
#include "storage/upload_store.hpp"
#include "tests/storage/place.hpp"

namespace divemesh::storage {

// A catalog with every store on it. Retries do not wait.
struct Stores {
    explicit Stores(const std::string& url) : catalog_(url) {}

    Upload finished_upload(const std::string& project = "default") {
        const Upload upload = uploads_.create({.project = project, .length_bytes = 10});
        return uploads_.advance(upload.id, 10);
    }

    // Returns the server's request once `upload` is complete; recordings differ by `content`.
    static NewDive request(const Upload& upload,
                           const std::string& content,
                           const std::string& preset = "") {
        return {.upload_id = upload.id,
                .project = upload.project,
                .name = content,
                .archive_sha256 = sha256_hex("archive of " + content),
                .content_sha256 = sha256_hex(content),
                .blob = "dives/" + upload.id + "/archive",
                .archive_bytes = *upload.length_bytes,
                .preset = preset};
    }

    CreatedDive create_dive(const std::string& content, const std::string& preset = "") {
        return dives_.create(request(finished_upload(), content, preset));
    }

    // Creates a dive whose intake has succeeded.
    Dive ready_dive(const std::string& content = "wreck") {
        const Dive dive = create_dive(content).dive;
        finish_intake(dive);
        return dives_.get(dive.id);
    }

    void finish_intake(const Dive& dive, const IntakeResult& result = {}) {
        const auto claim = jobs_.claim("intake worker", kLong);
        ASSERT_TRUE(claim);
        ASSERT_EQ(claim->dive.id, dive.id);
        ASSERT_TRUE(jobs_.finish_intake(claim->lease, result));
    }

    // Enqueues a reconstruction that differs from all others.
    Job enqueue(const Dive& dive, int max_attempts = 3) {
        NewJob job = work_on(dive);
        job.max_attempts = max_attempts;
        return jobs_.enqueue(job).job;
    }
    NewJob work_on(const Dive& dive) {
        return {.dive_id = dive.id,
                .preset = "standard",
                .options = {{"seed", ++num_works_}, {"by", getpid()}}};
    }

    Claim claim(std::chrono::milliseconds lease = kLong) {
        auto claim = jobs_.claim("worker", lease);
        if (!claim) throw std::runtime_error("nothing to claim");
        return std::move(*claim);
    }

    // The leases of a running reconstruction: an expired one, and the one of the worker that took
    // over.
    struct TwoWorkers {
        Lease stale;
        Lease winner;
    };
    TwoWorkers overtaken_worker() {
        enqueue(ready_dive());
        const Lease stale = claim(kOver).lease;
        return {.stale = stale, .winner = claim().lease};
    }

    std::vector<std::string> event_types(const std::string& subject) {
        std::vector<std::string> types;
        for (const Event& event : events_.since(0, "", 1000))
            if (event.subject == subject) types.push_back(event.type);
        return types;
    }

    static constexpr std::chrono::milliseconds kLong = std::chrono::minutes(10);
    static constexpr std::chrono::milliseconds kOver{-1};  // a lease that has ended already

    Catalog catalog_;
    UploadStore uploads_{catalog_};
    DiveStore dives_{catalog_};
    JobStore jobs_{catalog_, {.first = std::chrono::milliseconds(0)}};
    EventStore events_{catalog_};
    int num_works_ = 0;
};

class InFolder {
protected:
    InFolder() = default;
    ~InFolder() { remove_catalog(folder_.path()); }
    InFolder(const InFolder&) = delete;
    InFolder& operator=(const InFolder&) = delete;

    std::string url() const { return catalog_url(folder_.path()); }

    TemporaryFolder folder_;
};

// A test with all stores in a temporary folder.
class StoreTest : public testing::Test, protected InFolder, protected Stores {
protected:
    StoreTest() : Stores(url()) {}
};

// Returns success if `act` throws an Error of this code.
inline testing::AssertionResult throws_code(ErrorCode code, const std::function<void()>& act) {
    try {
        act();
    } catch (const Error& error) {
        if (error.code() == code) return testing::AssertionSuccess() << error.what();
        return testing::AssertionFailure() << to_string(error.code()) << ": " << error.what();
    }
    return testing::AssertionFailure() << "nothing was thrown";
}

}  // namespace divemesh::storage
