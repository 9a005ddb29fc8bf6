// Random calls, and after each of them the store has to be where a model of a few lines is.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "storage/job_changes.hpp"
#include "storage/job_ends.hpp"
#include "storage/queue_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

struct ModelJob {
    JobState state = JobState::Queued;
    std::int64_t rank_ms = 0;
    std::vector<std::string> parents;
    int num_attempts = 0;
    int max_attempts = 3;
    int num_silent_losses = 0;
    bool paused = false;
    bool lowered = false;
    bool cancel_requested = false;
    bool renewed = false;
};

// What the queue promises, without a database.
class Model {
public:
    std::map<std::string, ModelJob> jobs;
    bool queue_paused = false;

    void add(const Job& job, const std::vector<std::string>& parents) {
        ModelJob added{.rank_ms = queue_rank_ms(job.created_at_ms, job.priority),
                       .parents = parents,
                       .max_attempts = job.max_attempts};
        added.state = waits(added) ? JobState::Held : JobState::Queued;
        jobs[job.id] = added;
    }

    std::string next() const {
        std::pair<std::int64_t, std::string> first{0, ""};
        for (const auto& [id, job] : jobs)
            if (job.state == JobState::Queued && !queue_paused &&
                (first.second.empty() || std::pair(job.rank_ms, id) < first))
                first = {job.rank_ms, id};
        return first.second;
    }

    void claim(const std::string& id) {
        ModelJob& job = jobs[id];
        job.state = JobState::Running;
        ++job.num_attempts;
        job.renewed = false;
    }

    void succeed(const std::string& id) { finish(id, JobState::Succeeded); }

    void fail(const std::string& id, ErrorCode code) {
        ModelJob& job = jobs[id];
        job.num_silent_losses = 0;
        const bool was_lowered = job.lowered;
        if (code == ErrorCode::BadData) return finish(id, JobState::Failed);
        if (job.cancel_requested) return finish(id, JobState::Cancelled);
        if (code == ErrorCode::OutOfMemory && !was_lowered) {
            job.lowered = true;
            if (job.num_attempts >= job.max_attempts) --job.num_attempts;
        }
        const bool hopeless =
            code == ErrorCode::OutOfMemory ? was_lowered : job.num_attempts >= job.max_attempts;
        finish(id, hopeless ? JobState::Dead : JobState::Queued);
    }

    void lose(const std::string& id) {
        ModelJob& job = jobs[id];
        job.num_silent_losses = job.renewed ? 0 : job.num_silent_losses + 1;
        if (job.cancel_requested) return finish(id, JobState::Cancelled);
        const bool given_up =
            job.num_silent_losses >= kMaxSilentLosses || job.num_attempts >= job.max_attempts;
        finish(id, given_up ? JobState::Dead : JobState::Queued);
    }

    void release(const std::string& id) {
        ModelJob& job = jobs[id];
        --job.num_attempts;
        job.num_silent_losses = 0;
        finish(id, job.cancel_requested ? JobState::Cancelled : JobState::Queued);
    }

    bool can_cancel(const std::string& id) { return !is_finished(jobs[id].state); }
    void cancel(const std::string& id) {
        jobs[id].cancel_requested = true;
        if (jobs[id].state != JobState::Running) finish(id, JobState::Cancelled);
    }

    bool can_retry(const std::string& id) {
        return is_finished(jobs[id].state) && jobs[id].state != JobState::Succeeded &&
               !waits(jobs[id]);
    }
    void retry(const std::string& id) {
        ModelJob& job = jobs[id];
        job.num_attempts = job.num_silent_losses = 0;
        job.paused = job.lowered = job.cancel_requested = false;
        job.state = JobState::Queued;
        revive_children(id);
    }

    bool can_change(const std::string& id) {
        return jobs[id].state == JobState::Held || jobs[id].state == JobState::Queued;
    }
    void pause(const std::string& id, bool paused) {
        ModelJob& job = jobs[id];
        job.paused = paused;
        job.state = paused || waits(job) ? JobState::Held : JobState::Queued;
    }

private:
    bool waits(const ModelJob& job) const {
        return std::any_of(job.parents.begin(), job.parents.end(), [&](const std::string& parent) {
            return jobs.at(parent).state != JobState::Succeeded;
        });
    }
    static bool is_child(const ModelJob& job, const std::string& id) {
        return std::count(job.parents.begin(), job.parents.end(), id) > 0;
    }
    void revive_children(const std::string& id) {
        const auto came_to_nothing = [&](const std::string& parent) {
            const JobState state = jobs.at(parent).state;
            return is_finished(state) && state != JobState::Succeeded;
        };
        for (auto& [other, job] : jobs) {
            if (job.state != JobState::Failed || job.num_attempts > 0 || !is_child(job, id) ||
                std::any_of(job.parents.begin(), job.parents.end(), came_to_nothing))
                continue;
            job.state = JobState::Held;
            revive_children(other);
        }
    }
    void finish(const std::string& id, JobState to) {
        jobs[id].state = to;
        if (!is_finished(to)) return;
        for (auto& [other, job] : jobs) {
            if (job.state != JobState::Held || !is_child(job, id)) continue;
            if (to != JobState::Succeeded)
                finish(other, JobState::Failed);
            else if (!job.paused && !waits(job))
                job.state = JobState::Queued;
        }
    }
};

class JobModelTest : public StoreTest, public testing::WithParamInterface<unsigned> {
protected:
    JobModelTest() : dive_(ready_dive()), random_(GetParam()) {}

    int any(int below) { return std::uniform_int_distribution<int>(0, below - 1)(random_); }
    // "" when there is no job yet.
    std::string any_job() {
        if (model_.jobs.empty()) return "";
        return std::next(model_.jobs.begin(), any(static_cast<int>(model_.jobs.size())))->first;
    }
    // A lease that was handed out at some time: most are stale.
    std::string any_leased() {
        if (leases_.empty()) return "";
        return std::next(leases_.begin(), any(static_cast<int>(leases_.size())))->first;
    }
    bool holds(const std::string& id) { return model_.jobs[id].state == JobState::Running; }

    void enqueue_one() {
        NewJob request = work_on(dive_);
        request.priority = any(3) - 1;
        request.max_attempts = 1 + any(4);
        for (int i = any(3); i > 0; --i)
            if (const std::string id = any_job(); !id.empty()) request.parents.push_back(id);
        const bool hopeless =
            std::any_of(request.parents.begin(), request.parents.end(), [&](const auto& id) {
                const JobState state = model_.jobs[id].state;
                return is_finished(state) && state != JobState::Succeeded;
            });
        if (hopeless)
            EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.enqueue(request); }));
        else
            model_.add(jobs_.enqueue(request).job, request.parents);
    }
    void claim_one() {
        const std::string expected = model_.next();
        const auto claimed = jobs_.claim("worker", kLong);
        EXPECT_EQ(claimed ? claimed->job.id : "", expected);
        if (!claimed) return;
        model_.claim(expected);
        leases_[expected] = claimed->lease;
    }
    void end_one() {
        const std::string id = any_leased();
        if (id.empty()) return;
        const Lease& lease = leases_[id];
        const bool held = holds(id);
        switch (any(5)) {
            case 0:
                EXPECT_EQ(jobs_.succeed(lease, {}), held);
                if (held) model_.succeed(id);
                return;
            case 1: return fail_one(id, lease, ErrorCode::BadData);
            case 2: return fail_one(id, lease, ErrorCode::OutOfMemory);
            case 3: return fail_one(id, lease, ErrorCode::Unavailable);
            default:
                EXPECT_EQ(jobs_.release(lease), held);
                if (held) model_.release(id);
        }
    }
    void fail_one(const std::string& id, const Lease& lease, ErrorCode code) {
        const bool held = holds(id);
        EXPECT_EQ(jobs_.fail(lease, {code, "why"}), held);
        if (held) model_.fail(id, code);
    }
    void renew_one() {
        const std::string id = any_leased();
        if (id.empty()) return;
        const Renewal renewal = jobs_.renew(leases_[id], kLong);
        EXPECT_EQ(renewal.valid, holds(id));
        if (!renewal.valid) return;
        EXPECT_EQ(renewal.cancel_requested, model_.jobs[id].cancel_requested);
        model_.jobs[id].renewed = true;
    }
    void lose_one() {
        const std::string id = any_leased();
        if (id.empty() || !holds(id)) return;
        catalog_.transaction([&](soci::session& session) {
            session << "UPDATE jobs SET lease_expires_at_ms = 0 WHERE id = :id",
                soci::use(id, "id");
        });
        EXPECT_EQ(jobs_.requeue_expired(), 1);
        model_.lose(id);
    }
    void ask_of_one() {
        const std::string id = any_job();
        if (id.empty()) return;
        const auto ask = [&](bool allowed, const std::function<void()>& call) {
            if (allowed)
                call();
            else
                EXPECT_TRUE(throws_code(ErrorCode::Conflict, call));
            return allowed;
        };
        const bool paused = any(2) == 0;
        switch (any(3)) {
            case 0:
                if (ask(model_.can_cancel(id), [&] { jobs_.cancel(id); })) model_.cancel(id);
                return;
            case 1:
                if (ask(model_.can_retry(id), [&] { jobs_.retry(id); })) model_.retry(id);
                return;
            default:
                if (ask(model_.can_change(id), [&] { jobs_.change(id, {.paused = paused}); }))
                    model_.pause(id, paused);
        }
    }
    void pause_queue() {
        model_.queue_paused = any(4) == 0;
        QueueStore(catalog_).change("", {.paused = model_.queue_paused});
    }

    void step() {
        const int kind = any(20);
        if (kind < 5) return enqueue_one();
        if (kind < 10) return claim_one();
        if (kind < 14) return end_one();
        if (kind < 15) return renew_one();
        if (kind < 17) return lose_one();
        if (kind < 19) return ask_of_one();
        pause_queue();
    }

    void expect_equal() {
        std::size_t num_jobs = 0;
        PageRequest page{.limit = 200};
        do {
            const auto part = jobs_.list({.kind = JobKind::Reconstruct}, page);
            for (const Job& job : part.items) {
                const ModelJob& expected = model_.jobs.at(job.id);
                ASSERT_EQ(to_string(job.state), to_string(expected.state)) << job.id;
                ASSERT_EQ(job.num_attempts, expected.num_attempts) << job.id;
                ASSERT_EQ(job.paused, expected.paused) << job.id;
                ASSERT_EQ(job.lowered, expected.lowered) << job.id;
                ++num_jobs;
            }
            page.cursor = part.next_cursor;
        } while (!page.cursor.empty());
        ASSERT_EQ(num_jobs, model_.jobs.size());
    }

    Dive dive_;
    std::mt19937 random_;
    Model model_;
    std::map<std::string, Lease> leases_;  // the newest of each job
};

TEST_P(JobModelTest, RandomCallsLeadWhereTheModelIs) {
    for (int i = 0; i < 250; ++i) {
        step();
        if (i % 5 == 0) expect_equal();
        if (HasFailure()) FAIL() << "at step " << i;
    }
    expect_equal();
}

INSTANTIATE_TEST_SUITE_P(Seeds, JobModelTest, testing::Values(1U, 2U, 3U, 4U));

}  // namespace
}  // namespace divemesh::storage
