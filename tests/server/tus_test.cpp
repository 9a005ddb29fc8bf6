#include "storage/upload_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

TEST_F(TusTest, SaysWhatItSpeaksWithoutTokenOrVersion) {
    for (const char* target : {"/api/v1/uploads", "/api/v1/uploads/any"}) {
        const auto response = server.request("OPTIONS", target, "");
        EXPECT_EQ(response.status, 204);
        EXPECT_EQ(response.header("tus-version"), "1.0.0");
        EXPECT_EQ(response.header("tus-extension"),
                  "creation,creation-with-upload,creation-defer-length,expiration,checksum,"
                  "termination,concatenation");
        EXPECT_EQ(response.header("tus-checksum-algorithm"), "sha1,sha256,crc32c");
        EXPECT_FALSE(response.header("tus-max-size").empty());
        EXPECT_EQ(response.header("tus-resumable"), "1.0.0");
    }
}

TEST_F(TusTest, ProcessesNothingWithoutItsVersion) {
    const auto path = create_upload(server.port(), token, 10);
    for (const auto& [method, target] :
         {std::pair<std::string, std::string>{"POST", "/api/v1/uploads"},
          {"HEAD", path},
          {"PATCH", path},
          {"DELETE", path}}) {
        for (const Headers& version : {Headers{}, Headers{{"Tus-Resumable", "0.2.2"}}}) {
            auto headers = version;
            headers.emplace_back("Upload-Length", "10");
            headers.emplace_back("Upload-Offset", "0");
            headers.emplace_back("Content-Type", "application/offset+octet-stream");
            const auto response = server.request(method, target, token, headers);
            EXPECT_EQ(response.status, 412) << method;
            EXPECT_EQ(response.header("tus-version"), "1.0.0") << method;
        }
    }
    EXPECT_EQ(upload_offset(server.port(), token, path), 0);
}

TEST_F(TusTest, KeepsMetadataByteForByteAndAnswersWhereToGoOn) {
    const std::string metadata =
        "filename " + base64("wreck.zip") + ",other,dive " + base64(std::string(64, 'a'));
    const auto path = create_upload(server.port(), token, 1000, metadata);
    EXPECT_EQ(patch(path, 0, std::string(400, 'x')).header("upload-offset"), "400");
    const auto told = head(path);
    EXPECT_EQ(told.status, 200);
    EXPECT_EQ(told.header("upload-offset"), "400");
    EXPECT_EQ(told.header("upload-length"), "1000");
    EXPECT_EQ(told.header("upload-metadata"), metadata);
    EXPECT_EQ(told.header("cache-control"), "no-store");
}

TEST_F(TusTest, AnUploadInPiecesBecomesADiveOfTheSameBytes) {
    const auto path = create_upload(server.port(),
                                    token,
                                    300'000,
                                    "sha256 " + base64(sha256_hex(bytes)) + ",filename " +
                                        base64("wreck.zip") + ",job " + base64("standard"));
    for (std::size_t start = 0; start < bytes.size(); start += 100'000) {
        const auto response =
            patch(path, static_cast<std::int64_t>(start), bytes.substr(start, 100'000));
        ASSERT_EQ(response.status, 204) << response.body;
        EXPECT_EQ(response.header("divemesh-dive").empty(), start < 200'000);
    }
    const auto upload = server.request("GET", path, token).json();
    const std::string dive_id = upload["dive_id"];
    EXPECT_EQ(archive_of(dive_id), bytes);
    const auto dive = server.request("GET", "/api/v1/dives/" + dive_id, token).json();
    EXPECT_EQ(dive["archive_sha256"], sha256_hex(bytes));
    EXPECT_EQ(dive["name"], "wreck.zip");
    EXPECT_EQ(dive["state"], "checking");
    const auto jobs =
        server.request("GET", "/api/v1/jobs?dive_id=" + dive_id, token).json()["items"];
    EXPECT_EQ(jobs.size(), 2U);
}

TEST_F(TusTest, TakesTheFirstBytesWithTheCreation) {
    const auto part =
        create({{"Upload-Length", "300000"}, {"Content-Type", "application/offset+octet-stream"}},
               std::string_view(bytes).substr(0, 1000));
    EXPECT_EQ(part.status, 201);
    EXPECT_EQ(part.header("upload-offset"), "1000");
    const auto whole = create({{"Upload-Length", "300000"},
                               {"Upload-Metadata", "commit"},
                               {"Content-Type", "application/offset+octet-stream"}},
                              bytes);
    EXPECT_EQ(whole.status, 201);
    EXPECT_EQ(archive_of(whole.header("divemesh-dive")), bytes);
}

TEST_F(TusTest, RefusesAWrongOffsetAndChangesNothing) {
    const auto path = create_upload(server.port(), token, 1000);
    patch(path, 0, std::string(100, 'x'));
    for (const std::int64_t offset : {0, 99, 101, 1000}) {
        const auto response = patch(path, offset, std::string(10, 'y'));
        EXPECT_EQ(response.status, 409);
        EXPECT_EQ(response.header("upload-offset"), "100");
    }
    EXPECT_EQ(upload_offset(server.port(), token, path), 100);
}

TEST_F(TusTest, RefusesOffsetsAndLengthsThatAreNoNumbers) {
    const auto path = create_upload(server.port(), token, 1000);
    for (const char* offset : {"", "-1", "x", "1.5", "99999999999999999999"}) {
        Headers headers = tus_headers(token, {{"Content-Type", "application/offset+octet-stream"}});
        headers.emplace_back("Upload-Offset", offset);
        EXPECT_EQ(RawClient(server.port()).request("PATCH", path, headers, "x").status, 400)
            << offset;
        EXPECT_EQ(create({{"Upload-Length", offset}}).status, 400) << offset;
    }
    EXPECT_EQ(create({}).status, 400);
    EXPECT_EQ(create({{"Upload-Defer-Length", "0"}}).status, 400);
    EXPECT_EQ(create({{"Upload-Defer-Length", "1"}, {"Upload-Length", "5"}}).status, 400);
    EXPECT_EQ(create({{"Upload-Length", "9223372036854775807"}}).status, 413);
}

TEST_F(TusTest, RefusesAnotherContentType) {
    const auto path = create_upload(server.port(), token, 1000);
    for (const char* type : {"application/octet-stream", "text/plain", ""}) {
        Headers headers = tus_headers(token, {{"Upload-Offset", "0"}, {"Content-Type", type}});
        EXPECT_EQ(RawClient(server.port()).request("PATCH", path, headers, "x").status, 415)
            << type;
    }
    EXPECT_EQ(create({{"Upload-Length", "5"}, {"Content-Type", "text/plain"}}, "hello").status,
              415);
    EXPECT_EQ(upload_offset(server.port(), token, path), 0);
}

TEST_F(TusTest, StoresNothingPastTheLength) {
    const auto path = create_upload(server.port(), token, 100);
    EXPECT_EQ(patch(path, 0, std::string(101, 'x')).status, 413);
    EXPECT_EQ(upload_offset(server.port(), token, path), 0);
    RawClient client(server.port());
    Headers headers = patch_headers(token, 0);
    headers.emplace_back("Transfer-Encoding", "chunked");
    client.send(request_head("PATCH", path, headers, std::nullopt));
    client.send("78\r\n" + std::string(0x78, 'x') + "\r\n0\r\n\r\n");
    EXPECT_EQ(client.receive()->status, 413);
    EXPECT_EQ(upload_offset(server.port(), token, path), 100);
}

TEST_F(TusTest, TakesChunkedBodies) {
    const auto path = create_upload(server.port(), token, 10);
    RawClient client(server.port());
    Headers headers = patch_headers(token, 0);
    headers.emplace_back("Transfer-Encoding", "chunked");
    client.send(request_head("PATCH", path, headers, std::nullopt));
    client.send("4\r\nabcd\r\n3;extension=1\r\nefg\r\n0\r\n\r\n");
    const auto response = client.receive();
    EXPECT_EQ(response->status, 204);
    EXPECT_EQ(response->header("upload-offset"), "7");
}

TEST_F(TusTest, SaysGoOnBeforeTheBodyAndNoBeforeItIsSent) {
    const auto path = create_upload(server.port(), token, 10);
    RawClient willing(server.port());
    Headers headers = patch_headers(token, 0);
    headers.emplace_back("Expect", "100-continue");
    willing.send(request_head("PATCH", path, headers, 5));
    EXPECT_TRUE(willing.read_available().starts_with("HTTP/1.1 100"));
    willing.send("hello");
    EXPECT_EQ(willing.receive()->status, 204);
    RawClient refused(server.port());
    headers = patch_headers(token, 0);
    headers.emplace_back("Expect", "100-continue");
    refused.send(request_head("PATCH", path, headers, 5));
    EXPECT_TRUE(refused.read_available().starts_with("HTTP/1.1 409"));
}

TEST_F(TusTest, ALastRequestThatIsRepeatedDoesNoHarm) {
    const auto path = create_upload(server.port(), token, 300'000, "commit");
    const auto first = patch(path, 0, bytes);
    const auto again = patch(path, 300'000, "");
    EXPECT_EQ(again.status, 204);
    EXPECT_EQ(again.header("upload-offset"), "300000");
    EXPECT_EQ(again.header("divemesh-dive"), first.header("divemesh-dive"));
    EXPECT_EQ(upload_offset(server.port(), token, path), 300'000);
}

TEST_F(TusTest, RefusesAnArchiveThatIsNotWhatWasStated) {
    const std::string wrong = base64(std::string(64, '0'));
    const auto path = create_upload(server.port(), token, 300'000, "commit,sha256 " + wrong);
    EXPECT_EQ(patch(path, 0, bytes).status, 422);
    EXPECT_EQ(upload_offset(server.port(), token, path), 300'000);
    const auto id = path.substr(path.rfind('/') + 1);
    EXPECT_EQ(server.post_json("/api/v1/dives", token, {{"upload_id", id}}).status, 422);
    EXPECT_EQ(server.request("GET", "/api/v1/dives", token).json()["items"].size(), 0U);
}

TEST_F(TusTest, ForgetsATerminatedUploadAndItsBytes) {
    const auto path = create_upload(server.port(), token, 300'000);
    patch(path, 0, bytes.substr(0, 1000));
    EXPECT_EQ(terminate(path).status, 204);
    EXPECT_EQ(head(path).status, 410);
    EXPECT_EQ(head(path).header("upload-offset"), "");
    EXPECT_EQ(patch(path, 1000, "x").status, 410);
    EXPECT_EQ(server.request("GET", path, token).status, 410);
    EXPECT_EQ(terminate(path).status, 410);
    EXPECT_EQ(num_staged_files(), 0U);
}

TEST_F(TusTest, TakesAnotherMethodByHeader) {
    const auto path = create_upload(server.port(), token, 10);
    Headers headers = patch_headers(token, 0);
    headers.emplace_back("X-HTTP-Method-Override", "PATCH");
    EXPECT_EQ(RawClient(server.port()).request("POST", path, headers, "hello").status, 204);
    EXPECT_EQ(upload_offset(server.port(), token, path), 5);
}

TEST_F(TusTest, TwoUploadsOfOneDiveAreOneDive) {
    std::vector<std::string> dives;
    for (int i = 0; i < 2; ++i) {
        const auto path = create_upload(server.port(), token, 300'000, "job " + base64("standard"));
        dives.push_back(patch(path, 0, bytes).header("divemesh-dive"));
    }
    EXPECT_EQ(dives[0], dives[1]);
    EXPECT_EQ(archive_of(dives[0]), bytes);
    EXPECT_EQ(server.request("GET", "/api/v1/dives", token).json()["items"].size(), 1U);
    const auto jobs = server.request("GET", "/api/v1/jobs?kind=reconstruct", token).json()["items"];
    EXPECT_EQ(jobs.size(), 1U);
}

TEST_F(TusTest, MakesADiveOfAFinishedUploadAndAnswersTheSameWhenAskedAgain) {
    const auto path = create_upload(server.port(), token, 300'000);
    const auto id = path.substr(path.rfind('/') + 1);
    patch(path, 0, bytes.substr(0, 1000));
    EXPECT_EQ(server.post_json("/api/v1/dives", token, {{"upload_id", id}}).status, 409);
    patch(path, 1000, bytes.substr(1000));
    const auto made =
        server.post_json("/api/v1/dives", token, {{"upload_id", id}, {"name", "Barge 1"}});
    EXPECT_EQ(made.status, 201) << made.body;
    EXPECT_EQ(made.json()["name"], "Barge 1");
    EXPECT_EQ(made.header("location"), "/api/v1/dives/" + made.json()["id"].get<std::string>());
    const auto again =
        server.post_json("/api/v1/dives", token, {{"upload_id", id}, {"job", "paper"}});
    EXPECT_EQ(again.status, 200);
    EXPECT_EQ(again.json()["id"], made.json()["id"]);
    EXPECT_FALSE(again.header("divemesh-job").empty());
    EXPECT_EQ(archive_of(made.json()["id"]), bytes);
}

TEST_F(TusTest, RefusesAnUploadThatTheDiskCannotHold) {
    EXPECT_EQ(create({{"Upload-Length", "4000000000000"}}).status, 507);
}

TEST_F(TusTest, AnEmptyUploadIsNoDive) {
    const auto path = create_upload(server.port(), token, 0);
    EXPECT_EQ(upload_offset(server.port(), token, path), 0);
    const auto id = path.substr(path.rfind('/') + 1);
    EXPECT_EQ(server.post_json("/api/v1/dives", token, {{"upload_id", id}}).status, 422);
    EXPECT_EQ(create({{"Upload-Length", "0"}, {"Upload-Metadata", "commit"}}).status, 422);
    EXPECT_EQ(storage::UploadStore(server.catalog()).list_open().size(), 1U);
}

TEST_F(TusTest, AnUploadWhoseDiveWasDeletedIsNoDiveAnyMore) {
    const auto path = create_upload(server.port(), token, 300'000);
    ASSERT_EQ(patch(path, 0, bytes).status, 204);
    const nlohmann::json wanted = {{"upload_id", path.substr(path.rfind('/') + 1)},
                                   {"job", "standard"}};
    const auto made = server.post_json("/api/v1/dives", token, wanted);
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string dive = "/api/v1/dives/" + made.json()["id"].get<std::string>();
    ASSERT_EQ(server.request("DELETE", dive, token, {{"If-Match", "*"}}).status, 200);
    EXPECT_EQ(server.post_json("/api/v1/dives", token, wanted).status, 410);
    EXPECT_EQ(server.request("GET", "/api/v1/jobs?state=queued", token).json()["items"].size(), 0U);
}

TEST_F(TusTest, AnUploadersPresetNeedsTheScopeOfWhoCommits) {
    const auto path = create_upload(server.port(), token, 300'000, "job c3RhbmRhcmQ=");
    storage::UploadStore uploads(server.catalog());
    const auto id = path.substr(path.rfind('/') + 1);
    const auto stranger = server.make_token("default", {"dives:write"});
    EXPECT_EQ(patch(path, 0, bytes.substr(0, 1000)).status, 204);
    const auto part =
        RawClient(server.port())
            .request("PATCH", path, patch_headers(stranger, 1000), bytes.substr(1000));
    EXPECT_EQ(part.status, 403) << part.body;
    EXPECT_TRUE(uploads.get(id).complete());
    EXPECT_EQ(server.post_json("/api/v1/dives", stranger, {{"upload_id", id}}).status, 403);
    EXPECT_EQ(server.post_json("/api/v1/dives", token, {{"upload_id", id}}).status, 201);
}

}  // namespace
}  // namespace divemesh
