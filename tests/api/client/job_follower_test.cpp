#include "api/client/job_follower.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>

#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// Returns a port at which no server listens.
std::string url_of_no_server() {
    boost::asio::io_context io;
    const boost::asio::ip::tcp::acceptor closed(io,
                                                {boost::asio::ip::make_address("127.0.0.1"), 0});
    return "http://127.0.0.1:" + std::to_string(closed.local_endpoint().port());
}

TEST(JobFollowerTest, GivesUpAfterTheAccountsTime) {
    RestClient rest({parse_server_url(url_of_no_server()), "", 300ms});
    const auto begin = Clock::now();
    int num_waits = 0;
    try {
        follow_job(
            rest, "job_x", [](const Job&) {}, [&](const Error&, auto) { ++num_waits; });
        FAIL() << "there is no server";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Unavailable);
    }
    EXPECT_GE(Clock::now() - begin, 300ms);
    EXPECT_LT(Clock::now() - begin, 5s);
    EXPECT_GT(num_waits, 0);
}

}  // namespace
}  // namespace divemesh::api::client
