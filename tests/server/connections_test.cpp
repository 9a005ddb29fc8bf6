#include "server/connections.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <sys/resource.h>
#include <thread>

#include "server/open_files.hpp"

namespace divemesh::server {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;

class ConnectionsTest : public testing::Test {
protected:
    std::shared_ptr<Connection> connection_of(const std::string& address) {
        std::this_thread::sleep_for(1ms);  // so that none is as silent as another
        return std::make_shared<Connection>(
            asio::ip::tcp::socket(io), asio::ip::make_address(address), nullptr);
    }
    bool add(const std::string& address) { return connections.add(connection_of(address)); }
    std::shared_ptr<Connection> added(const std::string& address) {
        auto connection = connection_of(address);
        EXPECT_TRUE(connections.add(connection));
        return connection;
    }
    // Aborted connections notice it here.
    void run() {
        io.restart();
        io.run();
    }

    asio::io_context io;
    Connections connections{{8, 3, api::AllowedNetworks({"10.1.0.0/16"})}};
};

TEST_F(ConnectionsTest, OneAddressKeepsOnlyItsNewestConnections) {
    const auto first = added("192.0.2.1");
    const auto second = added("192.0.2.1");
    added("192.0.2.1");
    added("192.0.2.2");
    added("192.0.2.1");
    run();
    EXPECT_TRUE(first->stopping);
    EXPECT_FALSE(second->stopping);
}

TEST_F(ConnectionsTest, AByteKeepsAConnection) {
    const auto first = added("192.0.2.1");
    const auto second = added("192.0.2.1");
    added("192.0.2.1");
    first->note_received();
    added("192.0.2.1");
    run();
    EXPECT_FALSE(first->stopping);
    EXPECT_TRUE(second->stopping);
}

TEST_F(ConnectionsTest, AnAddressWhoseRequestsAreAllAtWorkGetsNoMore) {
    for (int i = 0; i < 3; ++i) {
        const auto connection = added("192.0.2.1");
        connection->note_valid_token();
        connection->set_serving(true);
    }
    EXPECT_FALSE(add("192.0.2.1"));
    EXPECT_TRUE(add("192.0.2.2"));
}

TEST_F(ConnectionsTest, ANetworkOfIpv6IsOneClient) {
    const auto first = added("2001:db8::1");
    added("2001:db8::2");
    added("2001:db8:0:0:ffff::3");
    added("2001:db8:0:1::1");
    run();
    EXPECT_FALSE(first->stopping);
    added("2001:db8::4");
    run();
    EXPECT_TRUE(first->stopping);
}

TEST_F(ConnectionsTest, LoopbackAndProxiesAreNotLimitedPerAddress) {
    for (const char* address : {"127.0.0.1", "10.1.2.3"}) {
        const auto first = added(address);
        std::vector<std::shared_ptr<Connection>> more;
        for (int i = 0; i < 3; ++i) more.push_back(added(address));
        run();
        EXPECT_FALSE(first->stopping) << address;
        connections.remove(first);
        for (const auto& connection : more) connections.remove(connection);
    }
}

// Two of eight are kept for clients with a valid token.
TEST_F(ConnectionsTest, SilentClientsTakeNoPlaceOfThoseWithAToken) {
    std::vector<std::shared_ptr<Connection>> known;
    for (int i = 0; i < 2; ++i) known.push_back(added("127.0.0.1"));
    for (const auto& connection : known) connection->note_valid_token();
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(add("127.0.0.1"));
    run();
    for (const auto& connection : known) EXPECT_FALSE(connection->stopping);
    const auto another = added("127.0.0.1");
    another->note_valid_token();
    EXPECT_TRUE(add("127.0.0.1"));
    run();
    EXPECT_FALSE(another->stopping);
}

TEST_F(ConnectionsTest, IfAllHaveATokenOneBetweenRequestsGoes) {
    std::vector<std::shared_ptr<Connection>> known;
    for (int i = 0; i < 8; ++i) {
        known.push_back(added("127.0.0.1"));
        known.back()->note_valid_token();
        known.back()->set_serving(i != 5);
    }
    EXPECT_TRUE(add("127.0.0.1"));
    run();
    for (int i = 0; i < 8; ++i)
        EXPECT_EQ(known[static_cast<std::size_t>(i)]->stopping, i == 5) << i;
}

TEST_F(ConnectionsTest, CountsThoseThatAreAbortedUntilTheyHaveEnded) {
    std::vector<std::shared_ptr<Connection>> all;
    for (int i = 0; i < 7; ++i) all.push_back(added("127.0.0.1"));
    EXPECT_EQ(connections.count(), 7U);
    connections.remove(all.front());
    EXPECT_EQ(connections.count(), 6U);
}

TEST(OpenFilesTest, RaisesTheSoftLimitAsFarAsTheHardOneAllows) {
    const rlimit low{100, 900};
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
    EXPECT_EQ(raise_open_files(50), 50);
    rlimit now{};
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &now), 0);
    EXPECT_EQ(now.rlim_cur, 300U);
    EXPECT_EQ(raise_open_files(2000), 350);
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &now), 0);
    EXPECT_EQ(now.rlim_cur, 900U);
}

}  // namespace
}  // namespace divemesh::server
