#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>

#include "storage/s3_blob_store.hpp"
#include "storage/s3_transfer.hpp"
#include "tests/storage/faulty_gateway.hpp"
#include "tests/storage/s3_server.hpp"
#include "tests/storage/store_fixture.hpp"
#include "tests/temporary_folder.hpp"

// What only a complete object store does: it compares signatures and hashes, knows rights, and
// lists unfinished uploads.
namespace divemesh::storage {
namespace {

using testing::HasSubstr;

class Ceph : public testing::Test {
protected:
    void SetUp() override {
        if (S3Server::shared_ceph() == nullptr)
            GTEST_SKIP() << "needs Ceph: apt-get install ceph-mon ceph-osd radosgw ceph-common";
    }
    static S3Location location() { return parse_s3_url(S3Server::shared_ceph()->url("rights")); }
    static S3Credentials credentials() { return S3Server::shared_ceph()->credentials(); }
    static std::string refusal_to_open(const S3Credentials& keys, const S3Settings& settings = {}) {
        try {
            open_s3_blob_store(location(), keys, {}, settings);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Unavailable);
            return error.what();
        }
        return "it opened";
    }
};

TEST_F(Ceph, AWrongSecretIsNamed) {
    EXPECT_THAT(refusal_to_open({credentials().access_key, "wrong", ""}),
                HasSubstr("AWS_SECRET_ACCESS_KEY"));
    EXPECT_THAT(refusal_to_open({"nobody", "wrong", ""}), HasSubstr("AWS_ACCESS_KEY_ID"));
}

TEST_F(Ceph, AWrongClockIsNamed) {
    EXPECT_THAT(refusal_to_open(credentials(), {.clock = [] { return std::time(nullptr) - 3600; }}),
                HasSubstr("clock"));
}

TEST_F(Ceph, RefusesBytesThatChangedOnTheirWay) {
    S3Client client(location(), credentials());
    int num_reads = 0;
    const HttpBody changing{.size_bytes = 1000, .read = [&](std::int64_t, std::span<char> buffer) {
                                std::fill(
                                    buffer.begin(), buffer.end(), num_reads++ == 0 ? 'a' : 'b');
                                return buffer.size();
                            }};
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { client.put("rights/x", changing); }));
    EXPECT_GT(num_reads, 1);
    EXPECT_FALSE(client.find("rights/x"));
}

TEST_F(Ceph, ShowsABlobToNobodyWithoutAKey) {
    S3Client client(location(), credentials());
    client.put("rights/secret", body_of("recording"));
    const std::string url = location().endpoint + "/dives/rights/secret";
    const HttpAnswer answer =
        HttpExchange({}).send({.method = "GET", .url = url, .max_answer_bytes = 1000});
    EXPECT_EQ(answer.status, 403) << answer.body << answer.failure;
}

TEST_F(Ceph, ForgetsThePartsOfAnUploadThatWasNotFinished) {
    S3Client client(location(), credentials());
    const std::string id = client.begin_upload("rights/parts");
    client.put_part("rights/parts", {id, 1}, body_of("part"));
    ASSERT_EQ(client.open_uploads("rights/").size(), 1U);
    EXPECT_TRUE(client.open_uploads("elsewhere/").empty());

    abort_uploads_before(client, "rights/", std::time(nullptr) - 3600);
    EXPECT_EQ(client.open_uploads("rights/").size(), 1U) << "it may still be under way";
    abort_uploads_before(client, "rights/", std::time(nullptr) + 3600);
    EXPECT_TRUE(client.open_uploads("rights/").empty());
}

// The object is there, and the upload that the next try names is not any more.
TEST_F(Ceph, TheAnswerToACompletionMayBeLost) {
    FaultyGateway gateway(S3Server::shared_ceph()->port());
    const TemporaryFolder folder;
    const auto blobs =
        open_s3_blob_store(parse_s3_url(S3Server::shared_ceph()->url("completion", gateway.port())),
                           credentials(),
                           {},
                           {.part_bytes = 5 << 20});
    for (const char byte : {'a', 'b'}) {
        gateway.make_fail(
            {.method = "POST", .target = "uploadId=", .trouble = Trouble::LostAnswer});
        std::ofstream(folder / "file") << std::string((5 << 20) + 1, byte);
        blobs->put_file("dives/x", folder / "file");
        char first = ' ';
        EXPECT_EQ(blobs->open("dives/x")->read_at(0, {&first, 1}), 1U);
        EXPECT_EQ(first, byte);
    }
    EXPECT_EQ(gateway.num_faults(), 2);

    gateway.make_fail(
        {.method = "POST", .target = "uploadId=", .answer = refusal(403, "AccessDenied")});
    std::ofstream(folder / "file") << std::string((5 << 20) + 1, 'c');
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
        blobs->put_file("dives/x", folder / "file");
    })) << "the object of the same size that is there is another";
    S3Client client(parse_s3_url(S3Server::shared_ceph()->url("")), credentials());
    EXPECT_TRUE(client.open_uploads("completion/").empty());
}

}  // namespace
}  // namespace divemesh::storage
