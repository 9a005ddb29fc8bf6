// The n-th call of every kind fails, for every n, in commit, claim, publish, complete, backup and
// restore: the error is told, catalog and blobs are consistent, and the process that saw the error
// can do the step again.
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "storage/backup.hpp"
#include "storage/data_id.hpp"
#include "tests/faults/fault_layer.hpp"
#include "tests/storage/site.hpp"

namespace divemesh::faults {
namespace {

namespace fs = std::filesystem;
using storage::Site;
using Step = std::function<void(Site&)>;

std::string bytes_of(storage::BlobStore& blobs, const std::string& key) {
    const auto reader = blobs.open(key);
    std::string bytes(static_cast<std::size_t>(reader->size_bytes()), '\0');
    bytes.resize(reader->read_at(0, bytes));
    return bytes;
}

void expect_whole(Site& site) {
    int sound = 0;
    site.catalog_.read([&](soci::session& session) {
        session << "SELECT COUNT(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'",
            soci::into(sound);
    });
    EXPECT_EQ(sound, 1) << "the catalog is damaged";
    expect_consistent(site);
    for (const auto& dive : site.dives_.list({}, {}).items)
        EXPECT_EQ(bytes_of(*site.blobs, dive.blob), Site::kRecording);
    for (const auto& job : site.all_jobs())
        for (const auto& artifact : site.jobs_.artifacts(job.id))
            EXPECT_EQ(bytes_of(*site.blobs, artifact.blob), artifact.name);
}

class StorageSweepTest : public testing::TestWithParam<Call> {
protected:
    // Runs `step` on a copy of what `prepare` makes, once for every call of a kind, which fails.
    // `finish` does in the same process what is left to do, and a new process finds it done.
    void fail_once_everywhere(const Step& prepare, const Step& step, const Step& finish) {
        {
            Site site(folder_ / "prepared");
            prepare(site);
        }
        sweep(Lasting::Once, step, finish);
    }
    // The same, and once more with all later calls failing too.
    void fail_everywhere(const Step& prepare, const Step& step, const Step& finish) {
        fail_once_everywhere(prepare, step, finish);
        if (!HasFailure()) sweep(Lasting::ForGood, step, finish);
    }

    void sweep(Lasting lasting, const Step& step, const Step& finish) {
        for (int number = 1;; ++number) {
            SCOPED_TRACE("call " + std::to_string(number) +
                         (lasting == Lasting::Once ? "" : " and all later ones"));
            const fs::path place = folder_ / "place" / std::to_string(num_places_++);
            fs::create_directories(place);
            fs::copy(folder_ / "prepared", place, fs::copy_options::recursive);
            take_as_durable(place);
            bool happened = false;
            {
                Site site(place);
                happened = run(step, site, {GetParam(), number, lasting});
                expect_whole(site);
                finish(site);
                expect_whole(site);
            }
            Site reopened(place);
            expect_whole(reopened);
            EXPECT_EQ(reopened.dives_.list({}, {}).items.size(), 1U);
            EXPECT_EQ(reopened.all_jobs().size(), 2U);
            fs::remove_all(place);
            if (happened && !HasFailure()) continue;
            EXPECT_TRUE(number > 1 || !is_made_by_every_step(GetParam())) << "no call has failed";
            return;
        }
    }

    // Returns whether a call failed. The step then has thrown, or what it says is done is done:
    // `finish` and expect_whole() see that.
    static bool run(const Step& step, Site& site, const Fault& fault) {
        const Armed armed(fault);
        try {
            step(site);
        } catch (const Error& error) {
            EXPECT_TRUE(armed.happened()) << error.what();
            EXPECT_TRUE(error.code() == ErrorCode::Unavailable ||
                        error.code() == ErrorCode::OutOfSpace)
                << error.what();
        }
        return armed.happened();
    }

    TemporaryFolder folder_;
    int num_places_ = 0;
};

TEST_P(StorageSweepTest, CommitOfAnUpload) {
    fail_everywhere([](Site& site) { site.stage_upload(); },
                    [](Site& site) { site.commit(); },
                    [](Site& site) { site.commit(); });
}

TEST_P(StorageSweepTest, Claim) {
    fail_everywhere([](Site& site) { site.queue_job(); },
                    [](Site& site) { site.take(); },
                    [](Site& site) {
                        site.lose_leases();
                        site.publish(site.take());
                        EXPECT_EQ(site.state_of_reconstruction(), JobState::Succeeded);
                    });
}

TEST_P(StorageSweepTest, PublishAndComplete) {
    fail_everywhere([](Site& site) { site.queue_job(); },
                    [](Site& site) { site.publish(site.take()); },
                    [](Site& site) {
                        if (site.state_of_reconstruction() == JobState::Succeeded) return;
                        site.lose_leases();
                        site.publish(site.take());
                        EXPECT_EQ(site.state_of_reconstruction(), JobState::Succeeded);
                    });
}

TEST_P(StorageSweepTest, FailureThatIsTriedAgain) {
    fail_everywhere([](Site& site) { site.queue_job(); },
                    [](Site& site) {
                        site.jobs_.fail(site.take(), {ErrorCode::Unavailable, "no network"});
                    },
                    [](Site& site) {
                        site.lose_leases();
                        site.publish(site.take());
                        EXPECT_EQ(site.state_of_reconstruction(), JobState::Succeeded);
                    });
}

fs::path backup_of(const Site& site) { return site.folder / "backup.tar"; }

void back_up(Site& site) { storage::write_backup(site.catalog_, *site.blobs, backup_of(site)); }

void restore(Site& site) {
    const auto blobs = storage::open_blob_store((site.folder / "restored").string());
    storage::read_backup(backup_of(site), site.folder / "restored.db", *blobs);
}

void expect_restored(const Site& site) {
    storage::Catalog catalog("sqlite://" + (site.folder / "restored.db").string());
    const auto blobs = storage::open_blob_store((site.folder / "restored").string());
    const auto dives = storage::DiveStore(catalog).list({}, {}).items;
    ASSERT_EQ(dives.size(), 1U);
    EXPECT_EQ(bytes_of(*blobs, dives[0].blob), Site::kRecording);
    EXPECT_EQ(storage::JobStore(catalog).list({}, {}).items.size(), 2U);
    EXPECT_EQ(storage::data_mismatch(catalog, *blobs), "");
}

// A backup that appears can be restored, whatever failed.
TEST_P(StorageSweepTest, Backup) {
    fail_once_everywhere([](Site& site) { site.queue_job(); },
                         back_up,
                         [](Site& site) {
                             if (!fs::exists(backup_of(site))) back_up(site);
                             restore(site);
                             expect_restored(site);
                         });
}

// A catalog that appears is whole, and its blobs are there.
TEST_P(StorageSweepTest, Restore) {
    const auto prepare = [](Site& site) {
        site.queue_job();
        back_up(site);
    };
    fail_once_everywhere(prepare, restore, [](Site& site) {
        if (!fs::exists(site.folder / "restored.db")) restore(site);
        expect_restored(site);
    });
}

INSTANTIATE_TEST_SUITE_P(Failing,
                         StorageSweepTest,
                         testing::ValuesIn(kCallsOfDisk),
                         [](const auto& sweep) { return std::string(name_of(sweep.param)); });

}  // namespace
}  // namespace divemesh::faults
