#include "server/resolve.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <future>

#include "schemas/error.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

// What the awaitable gives, or throws.
Addresses resolved(const std::string& host,
                   std::chrono::milliseconds timeout,
                   const Lookup& lookup = look_up) {
    asio::io_context io;
    Addresses addresses;
    std::exception_ptr failure;
    asio::co_spawn(io,
                   resolve_within(host, "80", timeout, lookup),
                   [&](const std::exception_ptr& error, const Addresses& found) {
                       failure = error;
                       addresses = found;
                   });
    io.run();
    if (failure) std::rethrow_exception(failure);
    return addresses;
}

TEST(ResolveTest, FindsWhatTheSystemKnows) {
    const Addresses found = resolved("127.0.0.1", 30s);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].address().to_string(), "127.0.0.1");
    EXPECT_EQ(found[0].port(), 80);
}

TEST(ResolveTest, HandsOnWhatWentWrong) {
    const Lookup broken = [](const auto&, const auto&) -> Addresses {
        throw std::runtime_error("no such name");
    };
    EXPECT_THROW(resolved("nowhere.invalid", 30s, broken), std::runtime_error);
}

TEST(ResolveTest, WaitsNoLongerThanItIsTold) {
    std::promise<void> release;
    std::promise<void> left;
    const auto released = release.get_future().share();
    const auto end = std::make_shared<std::promise<void>>(std::move(left));
    auto ended = end->get_future();
    const Lookup stuck = [released, end](const auto&, const auto&) -> Addresses {
        released.wait();
        end->set_value();
        return {};
    };
    try {
        resolved("slow.invalid", 50ms, stuck);
        FAIL() << "it was not given up";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Unavailable);
        EXPECT_NE(std::string(error.what()).find("slow.invalid"), std::string::npos);
    }
    release.set_value();  // the thread that is left behind finds nobody and ends
    EXPECT_EQ(ended.wait_for(30s), std::future_status::ready);
}

}  // namespace
}  // namespace divemesh::server
