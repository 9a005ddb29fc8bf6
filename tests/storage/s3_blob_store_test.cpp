#include "storage/s3_blob_store.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>
#include <thread>

#include "schemas/content_hash.hpp"
#include "storage/ids.hpp"
#include "storage/s3_transfer.hpp"
#include "tests/storage/faulty_gateway.hpp"
#include "tests/storage/s3_server.hpp"
#include "tests/storage/store_fixture.hpp"
#include "tests/temporary_folder.hpp"

// A blob store in an object store that, and whose network, fails.
namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kPart = std::size_t{5} << 20;
constexpr std::size_t kLarge = 2 * kPart + 5;  // three parts

S3Server* server() {
    static const std::unique_ptr<S3Server> kServer = S3Server::start_s3rver();
    return kServer.get();
}

// No part of it is like another.
std::string noise(std::size_t size) {
    std::string bytes(size, ' ');
    std::uint32_t state = 1;
    for (char& byte : bytes) {
        state = state * 1'664'525 + 1'013'904'223;
        byte = static_cast<char>(state >> 24);
    }
    return bytes;
}

std::string page(const std::string& content) {
    const std::string body = "<ListBucketResult>" + content + "</ListBucketResult>";
    return "HTTP/1.1 200 OK\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

class S3BlobStoreTest : public testing::Test {
protected:
    void SetUp() override {
        if (server() == nullptr) GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
        gateway_ = std::make_unique<FaultyGateway>(server()->port());
        blobs_ = open(location(), server()->credentials());
    }

    S3Location location() const { return parse_s3_url(server()->url(prefix_, gateway_->port())); }
    static S3Settings impatient() {
        return {
            .timeouts = {.connect = std::chrono::seconds(2), .silence = std::chrono::seconds(1)},
            .patience = std::chrono::seconds(1),
            .part_bytes = kPart};
    }
    std::unique_ptr<BlobStore> open(const S3Location& location,
                                    const S3Credentials& credentials,
                                    const S3Settings& settings = {
                                        .timeouts = {.silence = std::chrono::seconds(1)},
                                        .patience = std::chrono::seconds(10),
                                        .part_bytes = kPart}) const {
        return open_s3_blob_store(location, credentials, folder_ / "staged", settings);
    }
    // Returns the message with which the store refuses to open.
    std::string refusal_to_open(const S3Location& location,
                                const S3Credentials& credentials,
                                const S3Settings& settings = impatient()) const {
        try {
            open(location, credentials, settings);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Unavailable);
            return error.what();
        }
        return "it opened";
    }
    fs::path file_with(const std::string& bytes) const {
        std::ofstream(folder_ / "source", std::ios::binary) << bytes;
        return folder_ / "source";
    }
    std::string content_of(const std::string& key) {
        const auto reader = blobs_->open(key);
        std::string bytes(static_cast<std::size_t>(reader->size_bytes()), ' ');
        EXPECT_EQ(reader->read_at(0, bytes), bytes.size());
        return bytes;
    }
    std::ptrdiff_t num_requests(const std::string& part) const {
        const auto requests = gateway_->requests();
        return std::count_if(requests.begin(), requests.end(), [&](const std::string& line) {
            return line.find(part) != std::string::npos;
        });
    }
    // Writes a large blob and reads it back while `fault` happens; it must not be noticed.
    void expect_unnoticed(GatewayFault fault) {
        SCOPED_TRACE(fault.method + ' ' + fault.target + ' ' +
                     std::to_string(static_cast<int>(fault.trouble)));
        const int num_before = gateway_->num_faults();
        const int num_times = fault.num_times;
        gateway_->make_fail(std::move(fault));
        blobs_->put_file("dives/x", file_with(large_));
        const auto copy = blobs_->local_copy("dives/x", folder_ / "copy", sha256_hex(large_));
        EXPECT_EQ(fs::file_size(copy), large_.size());
        EXPECT_EQ(gateway_->num_faults() - num_before, num_times);
    }

    std::string prefix_ = "test-" + random_hex(8);
    std::string large_ = noise(kLarge);
    TemporaryFolder folder_;
    std::unique_ptr<FaultyGateway> gateway_;
    std::unique_ptr<BlobStore> blobs_;
};

TEST_F(S3BlobStoreTest, AnUnknownKeyIsNamed) {
    EXPECT_THAT(refusal_to_open(location(), {"NOBODY", "S3RVER", ""}),
                HasSubstr("AWS_ACCESS_KEY_ID"));
}

TEST_F(S3BlobStoreTest, AWrongClockIsNamed) {
    S3Settings late = impatient();
    late.clock = [] { return std::time(nullptr) - 3600; };
    EXPECT_THAT(refusal_to_open(location(), server()->credentials(), late), HasSubstr("clock"));
}

TEST_F(S3BlobStoreTest, AMissingBucketIsNamed) {
    S3Location elsewhere = location();
    elsewhere.bucket = "no-such-bucket";
    const std::string said = refusal_to_open(elsewhere, server()->credentials());
    EXPECT_THAT(said, HasSubstr("create it"));
    EXPECT_THAT(said, HasSubstr("s3://no-such-bucket/"));
}

TEST_F(S3BlobStoreTest, AStoreThatIsNotThereIsNamed) {
    S3Location closed = location();
    closed.endpoint = "http://127.0.0.1:" + std::to_string(free_port());
    EXPECT_THAT(refusal_to_open(closed, server()->credentials()), HasSubstr(closed.endpoint));
    closed.endpoint = "http://no-such-host.invalid";
    EXPECT_THAT(refusal_to_open(closed, server()->credentials()), HasSubstr("no-such-host"));
}

TEST_F(S3BlobStoreTest, AKeyWithoutTheRightIsNamed) {
    gateway_->make_fail({.method = "PUT", .answer = refusal(403, "AccessDenied")});
    try {
        blobs_->put_file("dives/x", file_with("x"));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Unavailable);
        EXPECT_THAT(error.what(), HasSubstr("s3:PutObject"));
        EXPECT_THAT(error.what(), Not(HasSubstr("S3RVER")));
    }
    EXPECT_EQ(num_requests("PUT "), 1) << "it was tried again in vain";
}

TEST_F(S3BlobStoreTest, AnAnswerToLookingForABlobThatSaysNothingIsExplained) {
    gateway_->make_fail(
        {.method = "HEAD", .answer = "HTTP/1.1 403 No\r\nContent-Length: 0\r\n\r\n"});
    gateway_->make_fail({.method = "GET", .answer = refusal(403, "RequestTimeTooSkewed")});
    try {
        blobs_->exists("dives/x");
        FAIL();
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("clock"));
    }
}

TEST_F(S3BlobStoreTest, AStoreThatIsFullIsSaidSo) {
    gateway_->make_fail({.method = "PUT", .answer = refusal(403, "QuotaExceeded")});
    EXPECT_TRUE(
        throws_code(ErrorCode::OutOfSpace, [&] { blobs_->put_file("dives/x", file_with("x")); }));
}

TEST_F(S3BlobStoreTest, ARegionThatIsNotTheBucketsIsNamed) {
    for (const std::string answer :
         {"HTTP/1.1 400 No\r\nContent-Length: 84\r\n\r\n<Error><Code>"
          "AuthorizationHeaderMalformed</Code><Region>eu-west-1</Region>  </Error>",
          "HTTP/1.1 301 No\r\nX-Amz-Bucket-Region: eu-west-1\r\nContent-Length: 45\r\n\r\n"
          "<Error><Code>PermanentRedirect</Code></Error>"}) {
        gateway_->make_fail({.method = "PUT", .answer = answer});
        try {
            blobs_->put_file("dives/x", file_with("x"));
            FAIL();
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), HasSubstr("region=eu-west-1"));
        }
    }
}

TEST_F(S3BlobStoreTest, ABusyStoreIsAskedAgain) {
    for (const std::string target : {"partNumber=2", "uploads", "uploadId"})
        for (const auto& [status, code] :
             {std::pair(503, "SlowDown"), std::pair(500, "InternalError")})
            expect_unnoticed({.method = target == "partNumber=2" ? "PUT" : "POST",
                              .target = target,
                              .answer = refusal(status, code),
                              .num_times = 2});
    expect_unnoticed({.method = "GET", .answer = refusal(503, "SlowDown"), .num_times = 4});
    expect_unnoticed({.method = "HEAD",
                      .answer = "HTTP/1.1 503 No\r\nContent-Length: 0\r\n\r\n",
                      .num_times = 2});
}

TEST_F(S3BlobStoreTest, ABadLinkIsNotNoticed) {
    expect_unnoticed({.method = "PUT", .trouble = Trouble::Reset, .num_times = 2});
    expect_unnoticed({.method = "PUT", .trouble = Trouble::LostAnswer});
    expect_unnoticed({.method = "PUT", .trouble = Trouble::Silence});
    expect_unnoticed({.method = "GET", .trouble = Trouble::Reset, .num_times = 2});
    expect_unnoticed({.method = "GET", .trouble = Trouble::HalfAnswer, .num_times = 2});
    expect_unnoticed({.method = "GET", .trouble = Trouble::Silence});
    expect_unnoticed({.method = "POST", .target = "uploads", .trouble = Trouble::LostAnswer});
}

TEST_F(S3BlobStoreTest, ACompletionMayFailAlthoughItSaidWell) {
    const std::string late = "HTTP/1.1 200 OK" + refusal(0, "InternalError").substr(13);
    expect_unnoticed({.method = "POST", .target = "uploadId=", .answer = late, .num_times = 2});
}

TEST_F(S3BlobStoreTest, OtherBytesThanWereAskedForAreRefused) {
    blobs_->put_file("dives/x", file_with("recording"));
    const auto reader = blobs_->open("dives/x");
    char byte[4];
    for (const std::string answer :
         {"HTTP/1.1 206 OK\r\nContent-Range: bytes 5-8/9\r\nContent-Length: 4\r\n\r\nreco",
          "HTTP/1.1 206 OK\r\nContent-Length: 4\r\n\r\nreco",
          "HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\nreco",
          "HTTP/1.1 206 OK\r\nContent-Range: bytes 0-8/9\r\nContent-Length: "
          "12\r\n\r\nrecordingabc"}) {
        gateway_->make_fail({.method = "GET", .answer = answer});
        EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { reader->read_at(0, byte); }))
            << answer;
    }
    EXPECT_EQ(reader->read_at(0, byte), 4U);
}

// The store keeps another object under the key than was stored, or its disk has changed the bytes.
TEST_F(S3BlobStoreTest, ACopyOfOtherBytesIsRefusedAndRemoved) {
    blobs_->put_file("dives/x", file_with("recordinG"));
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
        blobs_->local_copy("dives/x", folder_ / "copy", sha256_hex("recording"));
    }));
    EXPECT_FALSE(fs::exists(folder_ / "copy"));
    EXPECT_FALSE(fs::exists(folder_ / "copy.part"));
}

TEST_F(S3BlobStoreTest, AnEndlessAnswerIsCutOff) {
    const std::string endless =
        "HTTP/1.1 200 OK\r\n\r\n<ListBucketResult>" + std::string(std::size_t{20} << 20, 'x');
    gateway_->make_fail({.method = "GET", .target = "list-type", .answer = endless});
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { blobs_->children("dives/"); }));
}

TEST_F(S3BlobStoreTest, ListingsOfOtherPrefixesAreRefused) {
    gateway_->make_fail({.method = "GET",
                         .target = "list-type",
                         .answer = page("<Contents><Key>../../etc/passwd</Key></Contents>")});
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { blobs_->remove_prefix("dives/"); }));
}

TEST_F(S3BlobStoreTest, ListsEveryPage) {
    const std::string folder = prefix_ + "/blobs/jobs/";
    gateway_->make_fail(
        {.method = "GET",
         .target = "list-type",
         .answer = page("<Contents><Key>" + folder +
                        "a</Key></Contents><IsTruncated>true"
                        "</IsTruncated><NextContinuationToken>a/+=</NextContinuationToken>")});
    gateway_->make_fail(
        {.method = "GET",
         .target = "continuation-token=a%2F%2B%3D&",
         .answer = page("<CommonPrefixes><Prefix>" + folder + "b/</Prefix></CommonPrefixes>")});
    EXPECT_EQ(blobs_->children("jobs/"), (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(gateway_->num_faults(), 2);
}

// The staged bytes stay, so that the next try has them, and no parts stay in the store.
TEST_F(S3BlobStoreTest, ACommitThatFailsKeepsTheUpload) {
    blobs_ = open(location(), server()->credentials(), impatient());
    blobs_->open_staged("uploads/u")->write(large_);
    gateway_->make_fail({.method = "PUT",
                         .target = "partNumber=3",
                         .answer = refusal(503, "SlowDown"),
                         .num_times = 1000});
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable,
                            [&] { blobs_->commit_staged("uploads/u", "dives/u/archive"); }));
    EXPECT_EQ(blobs_->staged_size_bytes("uploads/u"), std::ssize(large_));
    EXPECT_FALSE(blobs_->exists("dives/u/archive"));
    EXPECT_EQ(num_requests("DELETE "), 1);

    gateway_ = std::make_unique<FaultyGateway>(server()->port());
    blobs_ = open(location(), server()->credentials());
    blobs_->commit_staged("uploads/u", "dives/u/archive");
    EXPECT_EQ(content_of("dives/u/archive"), large_);
    EXPECT_EQ(blobs_->staged_size_bytes("uploads/u"), 0);
}

TEST_F(S3BlobStoreTest, SendsAndFetchesEveryByteOnce) {
    blobs_->put_file("dives/x", file_with(large_));
    EXPECT_LT(static_cast<double>(gateway_->num_bytes_sent()), 1.02 * kLarge);
    const std::int64_t before = gateway_->num_bytes_received();
    blobs_->local_copy("dives/x", folder_ / "copy");
    EXPECT_LT(static_cast<double>(gateway_->num_bytes_received() - before), 1.02 * kLarge);
}

TEST_F(S3BlobStoreTest, ReadsAheadOfOneWhoReadsOn) {
    blobs_->put_file("dives/x", file_with(large_));
    const auto reader = blobs_->open("dives/x");
    std::string bytes(128 << 10, ' ');
    const auto before = num_requests("GET ");
    for (std::int64_t offset = 0; offset < reader->size_bytes();)
        offset += static_cast<std::int64_t>(reader->read_at(offset, bytes));
    EXPECT_LE(num_requests("GET ") - before, 9);  // of 81 reads
    EXPECT_LT(static_cast<double>(gateway_->num_bytes_received()), 1.1 * kLarge);
}

TEST_F(S3BlobStoreTest, ATransferEndsSoonWhenItIsToldTo) {
    blobs_->open_staged("uploads/u")->write(large_);
    gateway_->make_fail({.method = "PUT", .trouble = Trouble::Silence, .num_times = 1000});
    const auto begun = std::chrono::steady_clock::now();
    std::jthread stop([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        blobs_->stop_transfers();
    });
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable,
                            [&] { blobs_->commit_staged("uploads/u", "dives/u/archive"); }));
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(5));
    EXPECT_EQ(blobs_->staged_size_bytes("uploads/u"), std::ssize(large_));
}

TEST_F(S3BlobStoreTest, AWorkerNeedsNoStage) {
    const auto worker = open_s3_blob_store(location(), server()->credentials(), {});
    worker->put_file("jobs/x", file_with("mesh"));
    EXPECT_EQ(content_of("jobs/x"), "mesh");
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { worker->open_staged("uploads/u"); }));
    EXPECT_GT(worker->free_bytes(), std::int64_t{1} << 60);
}

TEST(S3TransferTest, NoObjectHasMoreThanTenThousandParts) {
    const std::int64_t mebibyte = std::int64_t{1} << 20;
    EXPECT_EQ(part_bytes_of(1, 16 * mebibyte), 16 * mebibyte);
    EXPECT_EQ(part_bytes_of(160'000 * mebibyte, 16 * mebibyte), 16 * mebibyte);
    EXPECT_EQ(part_bytes_of(160'000 * mebibyte + 1, 16 * mebibyte), 17 * mebibyte);
    for (const std::int64_t size : {500'000'000'000, std::int64_t{5} << 40}) {
        const std::int64_t part = part_bytes_of(size, 5 * mebibyte);
        EXPECT_LE((size + part - 1) / part, 10'000);
    }
    EXPECT_TRUE(throws_code(ErrorCode::TooLarge,
                            [&] { part_bytes_of((5 << 20) * mebibyte + 1, mebibyte); }));
}

}  // namespace
}  // namespace divemesh::storage
