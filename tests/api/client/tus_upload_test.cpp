#include "api/client/tus_upload.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "tests/api/client/fake_tus_server.hpp"
#include "tests/bytes_in_memory.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::api::client {
namespace {

std::string some_bytes(std::size_t count) {
    std::string text(count, '\0');
    std::uint32_t state = 1;
    for (char& c : text) c = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
    return text;
}

class TusUploadTest : public testing::Test {
protected:
    TusUploadTest() {
        settings.chunk_bytes = 100'000;
        settings.stall = std::chrono::seconds(20);
        settings.give_up_after = std::chrono::seconds(60);
        observer.on_resumed = [this](std::int64_t offset) { resumed_at = offset; };
        observer.on_wait = [this](const Error&, std::chrono::milliseconds) { ++num_waits; };
    }

    std::string upload() {
        const Account account{parse_server_url(server.url()), ""};
        const UploadState state(folder.path(), server.url(), "hash");
        return upload_by_tus(account, source, {{"filename", "a"}}, state, observer, settings);
    }

    FakeTusServer server;
    TemporaryFolder folder;
    std::string bytes = some_bytes(250'000);
    BytesInMemory source{bytes};
    TusSettings settings;
    TusObserver observer;
    std::int64_t resumed_at = -1;
    int num_waits = 0;
};

TEST_F(TusUploadTest, SendsEveryByteInPieces) {
    EXPECT_EQ(upload(), "/api/v1/uploads/u1");
    EXPECT_EQ(server.stored(), bytes);
    EXPECT_EQ(server.last_metadata(), "filename YQ==");
    EXPECT_EQ(num_waits, 0);
}

TEST_F(TusUploadTest, GoesOnWhereTheConnectionWasCut) {
    server.script_patches({{}, {0, 30'000, false}});
    upload();
    EXPECT_EQ(server.stored(), bytes);
    EXPECT_EQ(resumed_at, 130'000);
    EXPECT_EQ(server.body_bytes_received(), 250'000);
}

TEST_F(TusUploadTest, GoesOnAfterTheClientWasKilled) {
    server.script_patches({{}, {403, -1, false}});
    EXPECT_THROW(upload(), Error);
    upload();
    EXPECT_EQ(server.stored(), bytes);
    EXPECT_EQ(resumed_at, 100'000);
    EXPECT_EQ(server.num_created(), 1);
}

TEST_F(TusUploadTest, AsksWhatArrivedWhenTheAnswerIsLost) {
    settings.stall = std::chrono::milliseconds(300);
    server.script_patches({{0, -1, true}});
    upload();
    EXPECT_EQ(server.stored(), bytes);
    EXPECT_EQ(server.body_bytes_received(), 250'000);
}

TEST_F(TusUploadTest, TriesAgainWhileTheUploadIsLockedOrTheServerBroken) {
    server.script_patches({{423, -1, false}, {503, -1, false}});
    upload();
    EXPECT_EQ(server.stored(), bytes);
    EXPECT_EQ(num_waits, 2);
}

TEST_F(TusUploadTest, WaitsForRoomOnAFullDisk) {
    server.script_patches({{}, {507, -1, false}});
    upload();
    EXPECT_EQ(server.stored(), bytes);
    EXPECT_EQ(num_waits, 1);
}

TEST_F(TusUploadTest, StartsAnewWhenTheUploadExpiresUnderWay) {
    server.script_patches({{}, {410, -1, false}});
    EXPECT_EQ(upload(), "/api/v1/uploads/u2");
    EXPECT_EQ(server.stored(), bytes);
}

TEST_F(TusUploadTest, StartsAnewWhenTheServerForgotTheUpload) {
    server.script_patches({{}, {403, -1, false}});
    EXPECT_THROW(upload(), Error);
    server.forget_upload();
    EXPECT_EQ(upload(), "/api/v1/uploads/u2");
    EXPECT_EQ(server.stored(), bytes);
}

TEST_F(TusUploadTest, DoesNotRepeatWhatTheServerRefuses) {
    server.script_patches({{413, -1, false}});
    try {
        upload();
        FAIL() << "the upload was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::TooLarge);
    }
    EXPECT_EQ(num_waits, 0);
}

TEST_F(TusUploadTest, SendsSmallerPiecesThroughAProxyThatRefusesLargeOnes) {
    std::string advice;
    observer.on_wait = [&](const Error& reason, std::chrono::milliseconds) {
        advice = reason.what();
    };
    server.script_patches({{413, -1, false, true}, {413, 0, false, true}});
    EXPECT_EQ(upload(), "/api/v1/uploads/u1");
    EXPECT_EQ(server.stored(), bytes);
    EXPECT_NE(advice.find("client_max_body_size 0"), std::string::npos) << advice;
    EXPECT_NE(advice.find("16384"), std::string::npos) << advice;
}

TEST_F(TusUploadTest, GivesUpOnAProxyThatLetsNothingBy) {
    server.script_patches(std::deque<FakeTusServer::Fault>(3, {413, -1, false, true}));
    try {
        upload();
        FAIL() << "the upload was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::TooLarge);
        EXPECT_NE(std::string(error.what()).find("client_max_body_size 0"), std::string::npos);
    }
}

TEST_F(TusUploadTest, GivesUpWhenNothingGetsThrough) {
    settings.give_up_after = std::chrono::milliseconds(1);
    server.script_patches({{503, -1, false}});
    EXPECT_THROW(upload(), Error);
}

// RFC 4648, section 10.
TEST(TusMetadataTest, EncodesValuesInBase64) {
    EXPECT_EQ(tus_metadata({{"a", "f"}, {"b", "fo"}, {"c", "foo"}, {"d", "foobar"}, {"e", ""}}),
              "a Zg==,b Zm8=,c Zm9v,d Zm9vYmFy,e ");
}

TEST(ServerAddressTest, IsReadFromItsUrl) {
    const auto server = parse_server_url("http://boat.example:8080/lab/");
    EXPECT_EQ(server.host, "boat.example");
    EXPECT_EQ(server.port, "8080");
    EXPECT_EQ(server.base_path, "/lab");
    EXPECT_EQ(parse_server_url("http://[::1]:9").host, "::1");
    EXPECT_EQ(parse_server_url("http://[::1]:9").authority(), "[::1]:9");
    EXPECT_EQ(parse_server_url("http://boat").port, "80");
    EXPECT_FALSE(parse_server_url("http://boat").tls);
    EXPECT_EQ(parse_server_url("https://boat").port, "443");
    EXPECT_TRUE(parse_server_url("https://boat").tls);
    EXPECT_EQ(parse_server_url("https://boat/lab/").url(), "https://boat:443/lab");
    for (const char* bad : {"boat:8080", "ftp://boat", "http://", "http://boat:x", "http://a b"})
        EXPECT_THROW(parse_server_url(bad), Error) << bad;
}

}  // namespace
}  // namespace divemesh::api::client
