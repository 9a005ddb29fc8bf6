#include <openssl/sha.h>

#include "storage/upload_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

std::string sha1_base64(std::string_view bytes) {
    unsigned char digest[SHA_DIGEST_LENGTH];
    SHA1(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(), digest);
    return base64({reinterpret_cast<const char*>(digest), sizeof digest});
}

std::string id_of(const std::string& path) { return path.substr(path.rfind('/') + 1); }

TEST_F(TusTest, ALengthThatIsToldLaterIsToldOnce) {
    const auto made = create({{"Upload-Defer-Length", "1"}, {"Upload-Metadata", "commit"}});
    ASSERT_EQ(made.status, 201) << made.body;
    const auto path = made.header("location");
    EXPECT_EQ(head(path).header("upload-defer-length"), "1");
    EXPECT_EQ(head(path).header("upload-length"), "");
    EXPECT_EQ(patch(path, 0, bytes.substr(0, 1000)).status, 204);
    EXPECT_EQ(patch(path, 1000, "", {{"Upload-Length", "999"}}).status, 400);
    EXPECT_EQ(patch(path, 1000, bytes.substr(1000, 10), {{"Upload-Length", "300000"}}).status, 204);
    EXPECT_EQ(head(path).header("upload-defer-length"), "");
    EXPECT_EQ(head(path).header("upload-length"), "300000");
    EXPECT_EQ(patch(path, 1010, "", {{"Upload-Length", "300001"}}).status, 400);
    const auto last = patch(path, 1010, bytes.substr(1010), {{"Upload-Length", "300000"}});
    EXPECT_EQ(last.status, 204) << last.body;
    EXPECT_EQ(archive_of(last.header("divemesh-dive")), bytes);
}

TEST_F(TusTest, ARefusedRequestDoesNotFixTheLength) {
    const auto path = create({{"Upload-Defer-Length", "1"}}).header("location");
    EXPECT_EQ(patch(path, 0, bytes, {{"Upload-Length", "100"}}).status, 413);
    EXPECT_EQ(head(path).header("upload-defer-length"), "1");
    EXPECT_EQ(patch(path, 0, bytes, {{"Upload-Length", "300000"}}).status, 204);
}

TEST_F(TusTest, APartIsKeptAsLongAsAJoinNeedsIt) {
    const auto part = make_part(bytes);
    storage::UploadStore uploads(server.catalog());
    Upload whole;  // entered, and its bytes are still to be copied
    whole.project = "default";
    whole.concat = final_of({part});
    whole.length_bytes = 300'000;
    const auto joining = uploads.create_final(whole, {id_of(part)});
    EXPECT_EQ(terminate(part).status, 423);
    uploads.end(joining.id, UploadEnd::Terminated);
    EXPECT_EQ(terminate(part).status, 204);
}

TEST_F(TusTest, AnUploadMayEndWhereItIsWhenItsLengthIsTold) {
    const auto path = create({{"Upload-Defer-Length", "1"}}).header("location");
    patch(path, 0, bytes);
    const auto told = patch(path, 300'000, "", {{"Upload-Length", "300000"}});
    EXPECT_EQ(told.status, 204) << told.body;
    const auto dive = server.post_json("/api/v1/dives", token, {{"upload_id", id_of(path)}});
    EXPECT_EQ(dive.status, 201) << dive.body;
}

class SmallServerTest : public TusTest {
protected:
    SmallServerTest() : TusTest(config()) {}
    static server::ServerConfig config() {
        server::ServerConfig config;
        config.max_upload_bytes = 1000;
        config.max_open_uploads = 5;
        return config;
    }
};

class TokenLimitTest : public TusTest {
protected:
    TokenLimitTest() : TusTest(config()) {}
    static server::ServerConfig config() {
        server::ServerConfig config;
        config.max_token_uploads = 3;
        return config;
    }
};

TEST_F(TokenLimitTest, OneTokenCannotTakeAllThatItsProjectMayHaveOpen) {
    const auto laptop = server.make_token("default", {"dives:write"});
    const auto tablet = server.make_token("default", {"dives:write"});
    const auto begin = [&](const std::string& whose) {
        return RawClient(server.port())
            .request("POST", "/api/v1/uploads", tus_headers(whose, {{"Upload-Length", "9"}}));
    };
    for (int i = 0; i < 3; ++i) EXPECT_EQ(begin(laptop).status, 201);
    const auto refused = begin(laptop);
    EXPECT_EQ(refused.status, 429) << refused.body;
    EXPECT_NE(refused.body.find("this token has 3"), std::string::npos) << refused.body;
    const auto other = begin(tablet);
    EXPECT_EQ(other.status, 201);
    EXPECT_EQ(terminate(other.header("location")).status, 204);
    EXPECT_EQ(begin(laptop).status, 429) << "that was not one of its own";
}

TEST_F(SmallServerTest, AStreamWithoutLengthIsBounded) {
    const auto path = create({{"Upload-Defer-Length", "1"}}).header("location");
    EXPECT_EQ(patch(path, 0, std::string(1001, 'x')).status, 413);
    EXPECT_EQ(head(path).header("upload-offset"), "0");
    RawClient client(server.port());
    Headers headers = patch_headers(token, 0);
    headers.emplace_back("Transfer-Encoding", "chunked");
    client.send(request_head("PATCH", path, headers, std::nullopt));
    client.send("fa0\r\n" + std::string(4000, 'x') + "\r\n0\r\n\r\n");
    EXPECT_EQ(client.receive()->status, 413);
    EXPECT_EQ(head(path).header("upload-offset"), "1000");
    EXPECT_EQ(patch(path, 1000, "", {{"Upload-Length", "1001"}}).status, 413);
}

TEST_F(SmallServerTest, TheSamePartAThousandTimesIsTooLarge) {
    const auto part = make_part(std::string(400, 'x'));
    EXPECT_EQ(create({{"Upload-Concat", final_of({part, part, part})}}).status, 413);
    EXPECT_EQ(create({{"Upload-Concat", final_of(std::vector(200, part))}}).status, 413);
    const auto beyond = create({{"Upload-Concat", final_of(std::vector(1000, part))}});
    EXPECT_EQ(beyond.status, 431) << "the header alone is too large";
    EXPECT_EQ(create({{"Upload-Concat", final_of({part, part})}}).status, 201);
}

TEST_F(SmallServerTest, ManyUploadsThatAreNeverSentAreRefused) {
    std::string first;
    for (int i = 0; i < 5; ++i) first = create_upload(server.port(), token, 10);
    const auto refused = create({{"Upload-Length", "10"}});
    EXPECT_EQ(refused.status, 429);
    EXPECT_FALSE(refused.header("retry-after").empty());
    EXPECT_EQ(terminate(first).status, 204);
    EXPECT_EQ(create({{"Upload-Length", "10"}}).status, 201);
}

class ExpiryTest : public TusTest {
protected:
    ExpiryTest() : TusTest(config()) {}
    static server::ServerConfig config() {
        server::ServerConfig config;
        config.upload_lifetime = 2000ms;
        config.timeouts.sweep = 20ms;
        return config;
    }
    bool is_gone(const std::string& path) {
        return server.request("GET", path, token).status == 410;
    }
    void wait_until_gone(const std::string& path) {
        for (int i = 0; i < 1000 && !is_gone(path); ++i) std::this_thread::sleep_for(20ms);
    }
};

TEST_F(ExpiryTest, AnUploadWithoutBytesExpiresAndItsBytesGo) {
    const auto made = create({{"Upload-Length", "1000"}});
    EXPECT_TRUE(made.header("upload-expires").ends_with(" GMT")) << made.header("upload-expires");
    const auto path = made.header("location");
    EXPECT_FALSE(patch(path, 0, "hello").header("upload-expires").empty());
    wait_until_gone(path);
    EXPECT_EQ(head(path).status, 410);
    EXPECT_EQ(head(path).header("upload-offset"), "");
    EXPECT_EQ(patch(path, 5, "x").status, 410);
    for (int i = 0; i < 500 && num_staged_files() > 0; ++i) std::this_thread::sleep_for(20ms);
    EXPECT_EQ(num_staged_files(), 0U);
}

TEST_F(ExpiryTest, BytesMoveTheExpiryAndADiveNeverExpires) {
    const auto path = create_upload(server.port(), token, 300'000, "commit");
    const auto expires = [&] {
        return server.request("GET", path, token).json()["expires_at_ms"].get<std::int64_t>();
    };
    const auto first = expires();
    std::this_thread::sleep_for(50ms);
    patch(path, 0, bytes.substr(0, 10));
    EXPECT_GT(expires(), first);
    const auto last = patch(path, 10, bytes.substr(10));
    EXPECT_EQ(last.header("upload-expires"), "");
    EXPECT_EQ(expires(), 0);
}

TEST_F(ExpiryTest, TheSweeperLeavesAnUploadThatIsBeingSent) {
    const auto path = create_upload(server.port(), token, 1000);
    const auto other = create_upload(server.port(), token, 1000);
    RawClient sending(server.port());
    sending.send(request_head("PATCH", path, patch_headers(token, 0), 1000));
    sending.send(std::string(500, 'x'));
    wait_until_gone(other);  // as old, and not being sent
    std::this_thread::sleep_for(200ms);
    sending.send(std::string(500, 'y'));
    const auto answer = sending.receive();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 204);
    EXPECT_EQ(answer->header("upload-offset"), "1000");
}

TEST_F(TusTest, ARightChecksumIsTakenByEveryAlgorithm) {
    const std::string text = "123456789";
    const std::string checksums[] = {"sha1 98O8HYCOBHMq32eZZczDTKeuNEE=",
                                     "sha256 FeKw08M4keuw8e9gnsQZQgwg4yDOlMZfvIwzEkSOsiU=",
                                     "crc32c " + base64("\xE3\x06\x92\x83")};
    const auto path = create_upload(server.port(), token, 100);
    std::int64_t offset = 0;
    for (const std::string& checksum : checksums) {
        const auto answer = patch(path, offset, text, {{"Upload-Checksum", checksum}});
        EXPECT_EQ(answer.status, 204) << checksum << answer.body;
        offset += 9;
        EXPECT_EQ(patch(path, offset, "another", {{"Upload-Checksum", checksum}}).status, 460);
    }
    EXPECT_EQ(head(path).header("upload-offset"), "27");
}

TEST_F(TusTest, AWrongChecksumLeavesTheUploadAsItWas) {
    const auto path = create_upload(server.port(), token, 300'000, "commit");
    ASSERT_EQ(patch(path, 0, bytes.substr(0, 1000)).status, 204);
    const std::string middle = bytes.substr(1000, 200'000);
    const auto wrong = patch(path,
                             1000,
                             std::string(200'000, 'x'),
                             {{"Upload-Checksum", "sha1 " + sha1_base64(middle)}});
    EXPECT_EQ(wrong.status, 460);
    EXPECT_EQ(head(path).header("upload-offset"), "1000");
    EXPECT_EQ(
        patch(path, 1000, middle, {{"Upload-Checksum", "sha1 " + sha1_base64(middle)}}).status,
        204);
    const auto last = patch(path, 201'000, bytes.substr(201'000));
    EXPECT_EQ(archive_of(last.header("divemesh-dive")), bytes);
    EXPECT_EQ(num_staged_files(), 0U);
}

TEST_F(TusTest, OfAChunkThatIsCutNothingIsKept) {
    const auto path = create_upload(server.port(), token, 1000);
    {
        RawClient client(server.port());
        Headers headers = patch_headers(token, 0);
        headers.emplace_back("Upload-Checksum", "sha1 " + sha1_base64(std::string(1000, 'x')));
        client.send(request_head("PATCH", path, headers, 1000));
        client.send(std::string(500, 'x'));
        std::this_thread::sleep_for(100ms);
        client.reset();
    }
    EXPECT_EQ(head(path).header("upload-offset"), "0");
    EXPECT_EQ(num_staged_files(), 0U);
}

TEST_F(TusTest, ChecksumsThatAreNoneAreRefused) {
    const auto path = create_upload(server.port(), token, 1000);
    const std::string right = sha1_base64("hello");
    for (const std::string& checksum : {std::string("md5 XUFAKrxLKna5cZ2REBfFkg=="),
                                        "sha256 " + right,
                                        std::string("sha1"),
                                        std::string("sha1 "),
                                        "sha1 " + right + "=",
                                        "SHA1 " + right,
                                        "sha1  " + right,
                                        std::string("crc32c AAA="),
                                        std::string()})
        EXPECT_EQ(patch(path, 0, "hello", {{"Upload-Checksum", checksum}}).status, 400) << checksum;
    EXPECT_EQ(patch(path, 0, "hello", {{"Trailer", "Upload-Checksum"}}).status, 415);
    EXPECT_EQ(patch(path, 0, "hello", {{"Content-Encoding", "gzip"}}).status, 415);
    EXPECT_EQ(head(path).header("upload-offset"), "0");
    EXPECT_EQ(create({{"Upload-Length", "5"}, {"Upload-Checksum", "md5 XUFAKrxLKna5cZ2REBfFkg=="}})
                  .status,
              400);
}

TEST_F(TusTest, PartsMakeOneUploadThatBecomesADive) {
    const std::vector<std::string> parts = {make_part(bytes.substr(0, 100'000)),
                                            make_part(""),
                                            make_part(bytes.substr(100'000, 1)),
                                            make_part(bytes.substr(100'001))};
    EXPECT_EQ(head(parts[0]).header("upload-concat"), "partial");
    const Headers wanted = {
        {"Upload-Concat", "final;http://elsewhere.example" + final_of(parts).substr(6)},
        {"Upload-Metadata", "commit,sha256 " + base64(sha256_hex(bytes))}};
    const auto whole = create(wanted);
    ASSERT_EQ(whole.status, 201) << whole.body;
    EXPECT_EQ(archive_of(whole.header("divemesh-dive")), bytes);
    const auto told = head(whole.header("location"));
    EXPECT_EQ(told.header("upload-concat"), wanted[0].second);
    EXPECT_EQ(told.header("upload-offset"), "300000");
    EXPECT_EQ(told.header("upload-length"), "300000");
    EXPECT_EQ(patch(whole.header("location"), 300'000, "x").status, 403);
    EXPECT_EQ(head(parts[0]).status, 410) << "its bytes are in the final upload";
    EXPECT_EQ(num_staged_files(), 0U);
}

TEST_F(TusTest, AskedAgainForTheSamePartsTheAnswerIsTheSame) {
    const auto part = make_part(bytes);
    const Headers wanted = {{"Upload-Concat", final_of({part, part})}};
    const auto first = create(wanted);
    const auto again = create(wanted);
    EXPECT_EQ(first.status, 201) << first.body;
    EXPECT_EQ(again.status, 201) << again.body;
    EXPECT_EQ(again.header("location"), first.header("location"));
    const auto dive =
        server.post_json("/api/v1/dives", token, {{"upload_id", id_of(first.header("location"))}});
    EXPECT_EQ(archive_of(dive.json()["id"]), bytes + bytes);
}

TEST_F(TusTest, APartIsNoDiveAndAFinalUploadTakesNoBytes) {
    const auto part = make_part(bytes);
    EXPECT_EQ(server.post_json("/api/v1/dives", token, {{"upload_id", id_of(part)}}).status, 409);
    EXPECT_EQ(create({{"Upload-Concat", final_of({part})}, {"Upload-Length", "300000"}}).status,
              400);
    EXPECT_EQ(create({{"Upload-Concat", final_of({part})},
                      {"Content-Type", "application/offset+octet-stream"}},
                     "hello")
                  .status,
              400);
    const auto pending = create({{"Upload-Length", "5"},
                                 {"Upload-Concat", "partial"},
                                 {"Upload-Metadata", "commit"},
                                 {"Content-Type", "application/offset+octet-stream"}},
                                "hello");
    EXPECT_EQ(pending.header("divemesh-dive"), "");
}

TEST_F(TusTest, RefusesPartsThatAreNone) {
    const auto whole = create_upload(server.port(), token, 0);
    const auto unfinished =
        create({{"Upload-Length", "5"}, {"Upload-Concat", "partial"}}).header("location");
    EXPECT_EQ(create({{"Upload-Concat", final_of({whole})}}).status, 400);
    EXPECT_EQ(create({{"Upload-Concat", final_of({unfinished})}}).status, 409);
    EXPECT_EQ(create({{"Upload-Concat", "final;/api/v1/uploads/upload_none"}}).status, 404);
    for (const char* concat : {"final;",
                               "final; ",
                               "final",
                               "final;/etc/passwd",
                               "part",
                               "",
                               "final;/api/v1/uploads/",
                               "final;/api/v1/uploads/..%2fx"})
        EXPECT_EQ(create({{"Upload-Concat", concat}, {"Upload-Length", "1"}}).status, 400)
            << concat;
    const auto part = make_part("hello");
    terminate(part);
    EXPECT_EQ(create({{"Upload-Concat", final_of({part})}}).status, 410);
}

TEST_F(TusTest, AnotherProjectsPartIsNotSeen) {
    const auto part = make_part(bytes);
    const auto stranger = server.make_token("elsewhere", {"dives:write", "dives:read"});
    const auto stolen = RawClient(server.port())
                            .request("POST",
                                     "/api/v1/uploads",
                                     tus_headers(stranger, {{"Upload-Concat", final_of({part})}}));
    EXPECT_EQ(stolen.status, 404);
    EXPECT_EQ(head(part).header("upload-offset"), "300000");
}

TEST_F(TusTest, ComparesTheContentTypeWithoutCaseAndParameters) {
    const auto path = create_upload(server.port(), token, 1000);
    Headers headers = tus_headers(token, {{"Upload-Offset", "0"}});
    headers.emplace_back("Content-Type", "Application/Offset+Octet-Stream; charset=binary");
    EXPECT_EQ(RawClient(server.port()).request("PATCH", path, headers, "hello").status, 204);
    const auto made =
        create({{"Upload-Length", "5"}, {"Content-Type", "APPLICATION/OFFSET+OCTET-STREAM ;a=b"}},
               "hello");
    EXPECT_EQ(made.status, 201);
    EXPECT_EQ(made.header("upload-offset"), "5");
}

// The server does not offer checksum-trailer (tus 1.0), and a recipient may discard trailers (RFC
// 9110, 6.5). But a success would tell the client that its checksum was right.
TEST_F(TusTest, AChecksumTrailerThatWasNotAnnouncedIsNoSuccess) {
    const auto path = create_upload(server.port(), token, 1000);
    Headers headers = patch_headers(token, 0);
    headers.emplace_back("Transfer-Encoding", "chunked");
    RawClient client(server.port());
    client.send(request_head("PATCH", path, headers, std::nullopt) +
                "5\r\nhello\r\n0\r\nUpload-Checksum: sha1 " + sha1_base64("other") + "\r\n\r\n");
    const auto response = client.receive();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 415) << response->body;
    EXPECT_EQ(response->header("upload-offset"), "5");
    EXPECT_EQ(client.request("GET", "/healthz/live").status, 200) << "the connection goes on";
    EXPECT_EQ(head(path).header("upload-offset"), "5");
}

TEST_F(TusTest, OtherTrailersAreDropped) {
    const auto path = create_upload(server.port(), token, 1000);
    Headers headers = patch_headers(token, 0);
    headers.emplace_back("Transfer-Encoding", "chunked");
    headers.emplace_back("Upload-Checksum", "sha1 " + sha1_base64("hello"));
    RawClient client(server.port());
    client.send(request_head("PATCH", path, headers, std::nullopt) +
                "5\r\nhello\r\n0\r\nUpload-Offset: 7\r\nServer-Timing: x\r\n\r\n");
    const auto response = client.receive();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 204) << response->body;
    EXPECT_EQ(response->header("upload-offset"), "5");
}

// The first one has stored a part: it is told so, and the second one where to go on.
TEST_F(TusTest, APatchThatANewerOneStopsIsToldWhatItStored) {
    const auto path = create_upload(server.port(), token, 1000);
    RawClient first(server.port());
    first.send(request_head("PATCH", path, patch_headers(token, 0), 1000));
    first.send(std::string(400, 'x'));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const auto second = patch(path, 0, std::string(1000, 'x'));
    EXPECT_EQ(second.status, 409);
    EXPECT_EQ(second.header("upload-offset"), "400");
    const auto told = first.receive();
    ASSERT_TRUE(told);
    EXPECT_EQ(told->status, 204) << told->body;
    EXPECT_EQ(told->header("upload-offset"), "400");
    EXPECT_TRUE(first.at_end()) << "the rest of its body must not be read as a request";
}

TEST_F(TusTest, APatchThatIsStoppedBeforeItsFirstByteIsToldConflict) {
    const auto path = create_upload(server.port(), token, 1000);
    RawClient first(server.port());
    first.send(request_head("PATCH", path, patch_headers(token, 0), 1000));
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_EQ(patch(path, 0, std::string(1000, 'x')).status, 204);
    EXPECT_EQ(first.receive()->status, 409);
}

// A newer request stops an older one; whichever of them stored the bytes has to learn it.
TEST_F(TusTest, OfTwoPatchesAtOneOffsetTheOneThatStoredTheBytesIsTold204) {
    for (int round = 0; round < 60; ++round) {
        const auto path = create_upload(server.port(), token, 2'000'000);
        const std::string head = request_head("PATCH", path, patch_headers(token, 0), bytes.size());
        RawClient first(server.port());
        RawClient second(server.port());
        first.send(head);
        first.send(bytes);
        second.send(head);
        second.send(bytes);
        const auto a = first.receive();
        const auto b = second.receive();
        ASSERT_TRUE(a && b);
        const auto offset = upload_offset(server.port(), token, path);
        const int num_stored = (a->status == 204 ? 1 : 0) + (b->status == 204 ? 1 : 0);
        const auto size = static_cast<std::int64_t>(bytes.size());
        EXPECT_EQ(num_stored, offset == size ? 1 : 0)
            << a->status << ' ' << b->status << " at " << offset;
    }
}

}  // namespace
}  // namespace divemesh
