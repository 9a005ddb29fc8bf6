#include "storage/catalog.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <gmock/gmock.h>
#include <soci/soci.h>
#include <thread>
#include <vector>

#include "storage/migrations/sqlite.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

std::string text_of(Catalog& catalog, const std::string& query) {
    std::string text;
    catalog.read([&](soci::session& session) { session << query, soci::into(text); });
    return text;
}

TEST(SqliteCatalog, MakesItsSchemaInAnEmptyFolderAndFindsItAgain) {
    const TemporaryFolder folder;
    const std::string url = "sqlite://" + (folder / "a folder/catalog.db").string();
    for (int i = 0; i < 2; ++i) {
        Catalog catalog(url);
        EXPECT_EQ(catalog.schema_version(), static_cast<int>(sqlite_scripts().size()));
    }
}

TEST(Catalog, RefusesACatalogOfANewerVersion) {
    const Place place;
    const std::string url = place.url();
    Catalog(url).transaction(
        [](soci::session& session) { session << "UPDATE schema_version SET version = 999"; });

    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { Catalog{url}; }));
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { Catalog{url}; }));
}

TEST(SqliteCatalog, RefusesWhatItCannotOpen) {
    const TemporaryFolder folder;
    std::ofstream(folder / "text") << std::string(10'000, 'x');

    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [] { Catalog{"mysql://host/name"}; }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [] { Catalog{"sqlite://"}; }));
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { Catalog{(folder / "text").string()}; }));
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable,
                            [&] { Catalog{(folder / "text/catalog.db").string()}; }));
}

TEST(SqliteCatalog, LosesNothingThatWasCommittedToAPowerCut) {
    const TemporaryFolder folder;
    Catalog catalog((folder / "catalog.db").string());

    EXPECT_EQ(text_of(catalog, "PRAGMA journal_mode"), "wal");
    EXPECT_EQ(text_of(catalog, "PRAGMA synchronous"), "2");  // FULL
    EXPECT_EQ(text_of(catalog, "PRAGMA foreign_keys"), "1");
}

TEST(SqliteCatalog, ANonBlockingReadDoesNotWaitForAWriter) {
    const TemporaryFolder folder;
    const std::string url = (folder / "catalog.db").string();
    Catalog catalog(url);
    Catalog other(url);
    Catalog read_nonblocking = catalog.read_nonblocking();
    other.transaction([&](soci::session& session) {  // another connection holds the write lock
        session << "UPDATE event_sequence SET newest = 7";
        EXPECT_EQ(text_of(read_nonblocking, "SELECT newest FROM event_sequence"), "0");
        EXPECT_TRUE(throws_code(ErrorCode::Unavailable,
                                [&] { read_nonblocking.transaction([](soci::session&) {}); }));
    });
    EXPECT_EQ(text_of(read_nonblocking, "SELECT newest FROM event_sequence"), "7");
}

TEST(SqliteCatalog, ANonBlockingReadGetsNoConnectionInUse) {
    const TemporaryFolder folder;
    Catalog catalog((folder / "catalog.db").string());
    Catalog read_nonblocking = catalog.read_nonblocking();
    catalog.read([&](soci::session&) {  // has the only one that was opened
        EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
            text_of(read_nonblocking, "SELECT newest FROM event_sequence");
        }));
        EXPECT_EQ(text_of(catalog, "SELECT newest FROM event_sequence"), "0");
    });
    EXPECT_EQ(text_of(read_nonblocking, "SELECT newest FROM event_sequence"), "0");
}

TEST(SqliteCatalog, ANonBlockingReadUsesAReservedConnection) {
    const TemporaryFolder folder;
    Catalog catalog((folder / "catalog.db").string());
    Catalog read_nonblocking = catalog.read_nonblocking();
    const auto newest = [&] {
        return text_of(read_nonblocking, "SELECT newest FROM event_sequence");
    };
    catalog.reserve(2);
    catalog.transaction([&](soci::session&) { EXPECT_EQ(newest(), "0"); });
    catalog.read([&](soci::session&) {
        catalog.read([&](soci::session&) {
            EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { newest(); }));
        });
    });
}

// A non-blocking read restores the timeout of its connection.
TEST(SqliteCatalog, ABlockingReadWaitsAfterANonBlockingOne) {
    const TemporaryFolder folder;
    Catalog catalog((folder / "catalog.db").string());
    Catalog read_nonblocking = catalog.read_nonblocking();
    EXPECT_EQ(text_of(read_nonblocking, "PRAGMA busy_timeout"), "0");
    EXPECT_EQ(text_of(catalog, "PRAGMA busy_timeout"), "15000");
}

TEST(Catalog, AnAuditEventIsWrittenWithItsChangeOrNotAtAll) {
    const Place place;
    Catalog catalog(place.url());
    Catalog audited = catalog.with_audit(
        [](soci::session& session) { session << "UPDATE event_sequence SET newest = newest + 1"; });
    const auto num_events = [&] { return text_of(catalog, "SELECT newest FROM event_sequence"); };
    audited.transaction([](soci::session&) {});
    EXPECT_EQ(num_events(), "1");
    EXPECT_THROW(audited.transaction([](soci::session&) { throw std::runtime_error("no"); }),
                 std::runtime_error);
    audited.read([](soci::session&) {});
    catalog.transaction([](soci::session&) {});
    EXPECT_EQ(num_events(), "1");
    Catalog failing =
        catalog.with_audit([](soci::session&) { throw std::runtime_error("cannot be audited"); });
    EXPECT_THROW(failing.transaction(
                     [](soci::session& session) { session << "DELETE FROM event_sequence"; }),
                 std::runtime_error);
    EXPECT_EQ(num_events(), "1");
}

TEST(Catalog, ACheckSeesWhatTheChangeWillFindAndCanRefuseIt) {
    const Place place;
    Catalog catalog(place.url());
    Catalog another(place.url());
    const auto newest = [&] { return text_of(catalog, "SELECT newest FROM event_sequence"); };
    const auto add = [](soci::session& session) {
        session << "UPDATE event_sequence SET newest = newest + 1";
    };
    std::thread late;
    Catalog checked = catalog.with_check([&] {
        if (newest() != "0") throw Error(ErrorCode::PreconditionFailed, "changed");
        late = std::thread([&] { another.transaction(add); });
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        EXPECT_EQ(newest(), "0");
    });
    checked.transaction(add);
    late.join();
    EXPECT_EQ(newest(), "2");
    EXPECT_TRUE(throws_code(ErrorCode::PreconditionFailed, [&] { checked.transaction(add); }));
    EXPECT_EQ(newest(), "2");
}

TEST(Catalog, RollsBackWhatThrows) {
    const Place place;
    Catalog catalog(place.url());

    EXPECT_THROW(catalog.transaction([](soci::session& session) {
        session << "UPDATE event_sequence SET newest = 5";
        throw std::runtime_error("no");
    }),
                 std::runtime_error);

    EXPECT_EQ(text_of(catalog, "SELECT newest FROM event_sequence"), "0");
}

TEST(Catalog, WritersOfManyThreadsAndCatalogsLoseNoUpdate) {
    const Place place;
    const std::string url = place.url();
    Catalog first(url);
    Catalog second(url);  // stands for another process: it does not share the first one's lock
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; ++i)
        threads.emplace_back([&, i] {
            for (int k = 0; k < 10; ++k)
                (i % 2 ? first : second).transaction([](soci::session& session) {
                    int newest = 0;
                    session << "SELECT newest FROM event_sequence", soci::into(newest);
                    ++newest;
                    session << "UPDATE event_sequence SET newest = :newest", soci::use(newest);
                });
        });
    for (std::thread& thread : threads) thread.join();

    EXPECT_EQ(text_of(first, "SELECT newest FROM event_sequence"), "40");
}

TEST(Catalog, ItsClockIsTheSystemsInMilliseconds) {
    const Place place;
    Catalog catalog(place.url());
    const auto system_ms = [] {
        return std::chrono::duration_cast<std::chrono::milliseconds>(
                   std::chrono::system_clock::now().time_since_epoch())
            .count();
    };

    const auto before = system_ms();
    std::int64_t now_ms = 0;
    catalog.read([&](soci::session& session) { now_ms = Catalog::now_ms(session); });

    EXPECT_GE(now_ms, before - 1);
    EXPECT_LE(now_ms, system_ms() + 1);
}

}  // namespace
}  // namespace divemesh::storage
