#include "api/client/tus_upload.hpp"
#include "schemas/error.hpp"
#include "tests/bytes_in_memory.hpp"
#include "tests/flaky_proxy.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

namespace client = api::client;
using namespace std::chrono_literals;

// Our client, our server, and what is between a diver's laptop and the lab.
class BadLinkTest : public TusTest {
protected:
    BadLinkTest() {
        settings.chunk_bytes = 1 << 20;
        settings.stall = 300ms;
        settings.give_up_after = 60s;
    }

    // The path of the upload as the server has it.
    std::string upload(int port) {
        BytesInMemory source(whole);
        const client::Account account{
            client::parse_server_url("http://127.0.0.1:" + std::to_string(port)), token};
        const client::UploadState state(folder.path(), account.server.url(), "hash");
        return client::upload_by_tus(account, source, {{"commit", ""}}, state, {}, settings);
    }

    void expect_intact_through(const BadLink& link, int min_cuts) {
        FlakyProxy proxy(server.port(), link);
        const auto path = upload(proxy.port());
        const auto dive = server.request("GET", path, token).json()["dive_id"];
        EXPECT_EQ(archive_of(dive), whole);
        EXPECT_GE(proxy.num_cuts(), min_cuts);
        EXPECT_LT(static_cast<double>(proxy.num_bytes()),
                  1.2 * static_cast<double>(whole.size()) + 300'000.0);
    }

    TemporaryFolder folder;
    const std::string whole = random_bytes(6'000'000);
    client::TusSettings settings;
};

TEST_F(BadLinkTest, AnUploadSurvivesConnectionResets) {
    expect_intact_through({.cut = Cut::Reset, .cut_after_bytes = 1'300'000}, 4);
}

TEST_F(BadLinkTest, AnUploadSurvivesHalfOpenConnections) {
    expect_intact_through({.cut = Cut::HalfOpen, .cut_after_bytes = 1'300'000}, 4);
}

TEST_F(BadLinkTest, AnUploadSurvivesStalledConnections) {
    expect_intact_through({.cut = Cut::Stall, .cut_after_bytes = 1'300'000, .num_cuts = 3}, 3);
}

TEST_F(BadLinkTest, ParallelPartsSurviveCuts) {
    settings.num_parts = 3;
    for (const Cut cut : {Cut::Reset, Cut::HalfOpen}) {
        FlakyProxy proxy(server.port(), {.cut = cut, .cut_after_bytes = 700'000});
        const auto path = upload(proxy.port());
        const auto dive = server.request("GET", path, token).json()["dive_id"];
        EXPECT_EQ(archive_of(dive), whole);
        EXPECT_GE(proxy.num_cuts(), 6);
    }
    EXPECT_EQ(num_staged_files(), 0U);
}

TEST_F(BadLinkTest, AJoinWhoseAnswerWasLostIsNotDoneTwice) {
    settings.num_parts = 2;
    const auto first = upload(server.port());
    EXPECT_EQ(upload(server.port()), first) << "the state says that the parts were joined";
}

TEST_F(BadLinkTest, PartsThatTheServerForgotAreSentAnew) {
    settings.num_parts = 2;
    const auto first = upload(server.port());
    terminate(first);
    const auto second = upload(server.port());
    EXPECT_NE(second, first);
    EXPECT_EQ(head(second).header("upload-offset"), "6000000");
}

TEST_F(BadLinkTest, ARefusalOfOnePartEndsThemAll) {
    settings.num_parts = 3;
    settings.give_up_after = 0s;
    BytesInMemory source(whole);
    const client::Account stranger{
        client::parse_server_url("http://127.0.0.1:" + std::to_string(server.port())), "dm_none"};
    const client::UploadState state(folder.path(), stranger.server.url(), "hash");
    EXPECT_THROW(client::upload_by_tus(stranger, source, {}, state, {}, settings), Error);
}

}  // namespace
}  // namespace divemesh
