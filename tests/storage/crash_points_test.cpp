// SIGKILL at every statement boundary of commit, claim, publish, complete: after each, catalog and
// blobs are consistent, and doing it again ends as if nothing had happened.
#include <gtest/gtest.h>

#include <filesystem>

#include "storage/fault_point.hpp"
#include "tests/storage/child.hpp"
#include "tests/storage/site.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

class CrashPointsTest : public testing::Test {
protected:
    using Step = std::function<void(Site&)>;

    // Runs `step` on a copy of what `prepare` makes, once for every fault point it passes, killed
    // there; `verify` looks at each copy. Returns how many there were.
    int kill_everywhere(const Step& prepare, const Step& step, const Step& verify) {
        const fs::path prepared = folder_ / "prepared";
        {
            Site site(prepared);
            prepare(site);
        }
        for (int number = 1;; ++number) {
            const fs::path place = folder_ / std::to_string(number);
            copy_place(prepared, place);
            const bool killed = is_killed_at(number, place, step);
            {
                SCOPED_TRACE("killed at " + std::to_string(number));
                Site site(place);
                expect_consistent(site);
                verify(site);
                expect_consistent(site);
                EXPECT_EQ(site.dives_.list({}, {}).items.size(), 1U);
                EXPECT_EQ(site.all_jobs().size(), 2U);  // its intake and its reconstruction
            }
            if (!killed || HasFailure()) return number - 1;
            fs::remove_all(place);
            remove_catalog(place);
        }
    }

    static bool is_killed_at(int number, const fs::path& place, const Step& step) {
        const pid_t child = fork();
        if (child == 0) {
            Site site(place);
            kill_at_fault_point(number);
            step(site);
            _exit(HasFailure() ? 1 : 0);
        }
        int status = 0;
        waitpid(child, &status, 0);
        const bool killed = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
        EXPECT_TRUE(killed || (WIFEXITED(status) && WEXITSTATUS(status) == 0)) << status;
        return killed;
    }

    TemporaryFolder folder_;
};

TEST_F(CrashPointsTest, CommitOfAnUpload) {
    const int num_points = kill_everywhere(
        [](Site& site) { site.stage_upload(); },
        [](Site& site) { site.commit(); },
        [](Site& site) {
            site.commit();
            ASSERT_EQ(site.dives_.list({}, {}).items.size(), 1U);
            const auto reader = site.blobs->open(site.dives_.list({}, {}).items[0].blob);
            EXPECT_EQ(reader->size_bytes(), 10);
        });
    EXPECT_GT(num_points, 15);
}

TEST_F(CrashPointsTest, Claim) {
    const int num_points =
        kill_everywhere([](Site& site) { site.queue_job(); },
                        [](Site& site) { site.take(); },
                        [](Site& site) {
                            site.lose_leases();
                            const Lease lease = site.take();
                            site.publish(lease);
                            EXPECT_EQ(site.state_of_reconstruction(), JobState::Succeeded);
                        });
    EXPECT_GT(num_points, 8);
}

TEST_F(CrashPointsTest, PublishAndComplete) {
    const int num_points =
        kill_everywhere([](Site& site) { site.queue_job(); },
                        [](Site& site) { site.publish(site.take()); },
                        [](Site& site) {
                            if (site.state_of_reconstruction() != JobState::Succeeded) {
                                site.lose_leases();
                                site.publish(site.take());
                            }
                            for (const Job& job : site.all_jobs())
                                EXPECT_EQ(site.jobs_.artifacts(job.id).size(),
                                          job.kind == JobKind::Reconstruct ? 2U : 0U);
                            EXPECT_FALSE(site.jobs_.claim("worker", Stores::kLong));
                        });
    EXPECT_GT(num_points, 25);
}

TEST_F(CrashPointsTest, CompletionOfAnIntakeThatOthersWaitFor) {
    const auto finish = [](Site& site) {
        const Claim intake = site.claim();
        ASSERT_EQ(intake.job.kind, JobKind::Intake);
        EXPECT_TRUE(site.jobs_.finish_intake(intake.lease, {}));
    };
    const int num_points = kill_everywhere(
        [](Site& site) { site.stage_upload(), site.commit(); },
        finish,
        [&](Site& site) {
            site.lose_leases();
            const bool checking = site.dives_.list({}, {}).items.at(0).state == DiveState::Checking;
            EXPECT_EQ(site.state_of_reconstruction() == JobState::Held, checking);
            if (checking) finish(site);
            EXPECT_EQ(site.state_of_reconstruction(), JobState::Queued);
        });
    EXPECT_GT(num_points, 8);
}

TEST_F(CrashPointsTest, FailureThatIsTriedAgain) {
    const int num_points =
        kill_everywhere([](Site& site) { site.queue_job(); },
                        [](Site& site) {
                            site.jobs_.fail(site.take(), {ErrorCode::Unavailable, "no network"});
                        },
                        [](Site& site) {
                            site.lose_leases();
                            site.publish(site.take());
                            EXPECT_EQ(site.state_of_reconstruction(), JobState::Succeeded);
                        });
    EXPECT_GT(num_points, 8);
}

}  // namespace
}  // namespace divemesh::storage
