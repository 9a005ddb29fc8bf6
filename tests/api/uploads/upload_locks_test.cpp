#include "api/uploads/upload_locks.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <optional>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

struct Shared {
    asio::io_context io;
    UploadLocks locks{io.get_executor(), 300ms};
    int num_holding = 0;
    int max_holding = 0;
    int num_refused = 0;
};

// Holds the lock for `hold_ms`, or until it is asked to stop if it `listens`.
asio::awaitable<void> work(Shared& shared, std::string upload, bool listens, int hold_ms) {
    std::optional<UploadLocks::Lock> lock;
    const auto asked_to_stop = std::make_shared<std::atomic<bool>>(false);
    auto stop = [asked_to_stop] { *asked_to_stop = true; };
    try {
        lock.emplace(co_await shared.locks.take(upload, stop));
    } catch (const Error&) {
        ++shared.num_refused;
        co_return;
    }
    shared.max_holding = std::max(shared.max_holding, ++shared.num_holding);
    asio::steady_timer pause(shared.io);
    for (int waited = 0; waited < hold_ms && !(listens && *asked_to_stop); waited += 5) {
        pause.expires_after(5ms);
        co_await pause.async_wait(asio::use_awaitable);
    }
    --shared.num_holding;
}

TEST(UploadLocksTest, ANewerRequestEndsTheOlderAndNeverWorksBesideIt) {
    Shared shared;
    for (int i = 0; i < 5; ++i)
        asio::co_spawn(shared.io, work(shared, "upload_a", true, 60'000), asio::detached);
    asio::co_spawn(shared.io, work(shared, "upload_a", true, 20), asio::detached);
    shared.io.run();
    EXPECT_EQ(shared.max_holding, 1);
    EXPECT_EQ(shared.num_refused, 0);
}

TEST(UploadLocksTest, DifferentUploadsDoNotWaitForEachOther) {
    Shared shared;
    asio::co_spawn(shared.io, work(shared, "upload_a", false, 100), asio::detached);
    asio::co_spawn(shared.io, work(shared, "upload_b", false, 100), asio::detached);
    shared.io.run();
    EXPECT_EQ(shared.max_holding, 2);
}

TEST(UploadLocksTest, GivesUpOnARequestThatDoesNotEnd) {
    Shared shared;
    asio::co_spawn(shared.io, work(shared, "upload_a", false, 2'000), asio::detached);
    asio::co_spawn(shared.io, work(shared, "upload_a", false, 10), asio::detached);
    shared.io.run();
    EXPECT_EQ(shared.num_refused, 1);
    EXPECT_EQ(shared.max_holding, 1);
}

asio::awaitable<void> take_into(std::optional<UploadLocks::Lock>& lock, UploadLocks& locks) {
    std::function<void()> stop = [] {};
    lock.emplace(co_await locks.take("upload_a", std::move(stop)));
}

// This happens when a server ends while a request holds its lock.
TEST(UploadLocksTest, ALockMayOutliveTheLocks) {
    asio::io_context io;
    std::optional<UploadLocks::Lock> lock;
    {
        UploadLocks locks(io.get_executor());
        asio::co_spawn(io, take_into(lock, locks), asio::detached);
        io.run();
        ASSERT_TRUE(lock);
    }
    lock.reset();
    io.restart();
    EXPECT_EQ(io.run(), 0U);
}

}  // namespace
}  // namespace divemesh::api
