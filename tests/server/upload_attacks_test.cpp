#include <atomic>
#include <thread>

#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

// Every regular file below the data folder, to see that nothing came to be elsewhere.
std::vector<std::string> files_in(const std::filesystem::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            names.push_back(entry.path().lexically_relative(folder).string());
    std::sort(names.begin(), names.end());
    return names;
}

TEST_F(TusTest, IdsThatArePathsLeadNowhere) {
    const auto path = create_upload(server.port(), token, 10);
    const auto before = files_in(server.data());
    const std::string id = path.substr(path.rfind('/') + 1);
    const std::vector<std::string> names = {std::string("..%2f") + id,
                                            "%2e%2e%2f%2e%2e%2fetc%2fpasswd",
                                            "..%5c..%5cx",
                                            id + "%00",
                                            "%252e%252e%252f",
                                            "%2fetc%2fpasswd",
                                            "C:%5cx",
                                            std::string(4000, 'a'),
                                            id + ".",
                                            id + "%20",
                                            "uploads%2f" + id,
                                            "%c0%ae%c0%ae%2f",
                                            "%ef%bc%8e%ef%bc%8e%2f"};
    for (const std::string& name : names) {
        const std::string target = "/api/v1/uploads/" + name;
        for (const char* method : {"HEAD", "GET", "DELETE"}) {
            const int status =
                RawClient(server.port()).request(method, target, tus_headers(token)).status;
            EXPECT_TRUE(status == 404 || status == 400) << status << ' ' << method << ' ' << name;
        }
        const int status = patch(target, 0, "x").status;
        EXPECT_TRUE(status == 404 || status == 400) << status << ' ' << name;
    }
    EXPECT_EQ(files_in(server.data()), before);
    EXPECT_EQ(upload_offset(server.port(), token, path), 0);
}

TEST_F(TusTest, AClientCannotChooseAnId) {
    const auto headers =
        tus_headers(token, {{"Upload-Length", "10"}, {"Upload-Id", "mine"}, {"Slug", "../mine"}});
    EXPECT_EQ(RawClient(server.port()).request("POST", "/api/v1/uploads/mine", headers).status,
              405);
    const auto made = RawClient(server.port()).request("POST", "/api/v1/uploads", headers);
    EXPECT_EQ(made.header("location").find("mine"), std::string::npos);
    EXPECT_EQ(server.request("GET", "/api/v1/uploads/mine", token).status, 404);
}

TEST_F(TusTest, MetadataGetsIntoNoOtherHeaderAndNoPath) {
    const std::string hostile = "a\r\nSet-Cookie: x=1\r\n\r\n\"../../\xe2\x80\xaegpj.exe";
    const auto path =
        create_upload(server.port(), token, 300'000, "commit,filename " + base64(hostile));
    const auto last = patch(path, 0, bytes);
    EXPECT_EQ(last.header("set-cookie"), "");
    const auto dive = server.request("GET", "/api/v1/dives/" + last.header("divemesh-dive"), token);
    EXPECT_EQ(dive.header("set-cookie"), "");
    const std::string name = dive.json()["name"];
    EXPECT_EQ(name.find_first_of("\r\n/\\"), std::string::npos) << name;
    RawClient raw(server.port());
    raw.send("POST /api/v1/uploads HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer " + token +
             "\r\nTus-Resumable: 1.0.0\r\nUpload-Length: 1\r\nUpload-Metadata: a\x01 YQ==\r\n\r\n");
    EXPECT_EQ(raw.receive()->status, 400);
}

TEST_F(TusTest, MetadataThatNamesServerFilesMeansNothing) {
    const std::string secret = base64((server.data() / "admin.token").string());
    const auto path = create_upload(
        server.port(),
        token,
        300'000,
        "commit,blob " + secret + ",file.path " + secret + ",path " + secret + ",x-file " + secret);
    const auto last = patch(path, 0, bytes);
    EXPECT_EQ(archive_of(last.header("divemesh-dive")), bytes);
    EXPECT_TRUE(std::filesystem::exists(server.data() / "admin.token"));
}

TEST_F(TusTest, MultipartIsNoUpload) {
    std::string body;
    for (int i = 0; i < 10'000; ++i) body += "--x\r\nContent-Disposition: form-data\r\n\r\n\r\n";
    const Headers headers = {{"Content-Type", "multipart/form-data; boundary=x"}};
    Headers with_length = headers;
    with_length.emplace_back("Upload-Length", "5");
    EXPECT_EQ(create(with_length, body).status, 415);
    const auto path = create_upload(server.port(), token, 10);
    Headers wrong = tus_headers(token, headers);
    wrong.emplace_back("Upload-Offset", "0");
    EXPECT_EQ(RawClient(server.port()).request("PATCH", path, wrong, body).status, 415);
    EXPECT_EQ(upload_offset(server.port(), token, path), 0);
}

TEST_F(TusTest, LengthsBeyondEveryBoundAreRefused) {
    for (const char* length : {"9223372036854775807", "4398046511105"})
        EXPECT_EQ(create({{"Upload-Length", length}}).status, 413) << length;
    for (const char* length : {"9223372036854775808", "18446744073709551616", "-1", "1e3", "0x10"})
        EXPECT_EQ(create({{"Upload-Length", length}}).status, 400) << length;
    EXPECT_EQ(
        create({{"Upload-Length", "1"}, {"Upload-Metadata", "a " + base64(std::string(9000, 'x'))}})
            .status,
        400);
}

// Eight clients send the same upload from the same offset at once: one wins each time, the others
// get a conflict, and the bytes of the winner are stored.
TEST_F(TusTest, ConcurrentClientsWithTheSameBytesDoNoHarm) {
    const auto path = create_upload(server.port(), token, 300'000, "commit");
    std::vector<std::thread> clients;
    std::atomic<int> num_broken = 0;
    for (int i = 0; i < 8; ++i)
        clients.emplace_back([&] {
            for (int tries = 0; tries < 200; ++tries) {
                const auto offset = upload_offset(server.port(), token, path);
                if (offset == 300'000) return;
                const auto answer =
                    patch(path,
                          offset,
                          std::string_view(bytes).substr(static_cast<std::size_t>(offset), 30'000));
                if (answer.status != 204 && answer.status != 409 && answer.status != 413)
                    ++num_broken;
            }
        });
    for (auto& client : clients) client.join();
    EXPECT_EQ(num_broken, 0);
    const auto told = patch(path, 300'000, "");
    EXPECT_EQ(archive_of(told.header("divemesh-dive")), bytes);
}

TEST_F(TusTest, TerminationWhileBytesComeLeavesNothing) {
    for (int i = 0; i < 5; ++i) {
        const auto path = create_upload(server.port(), token, 300'000);
        RawClient sending(server.port());
        sending.send(request_head("PATCH", path, patch_headers(token, 0), 300'000));
        sending.send(std::string_view(bytes).substr(0, 10'000u * static_cast<unsigned>(i)));
        EXPECT_EQ(terminate(path).status, 204);
        EXPECT_EQ(head(path).status, 410);
    }
    EXPECT_EQ(num_staged_files(), 0U);
}

TEST_F(TusTest, ATokenThatWasRevokedMeanwhileMakesNoDive) {
    const auto made =
        server.post_json("/api/v1/tokens", token, {{"name", "laptop"}, {"scopes", {"dives:write"}}})
            .json();
    const std::string secret = made["secret"];
    const std::string token_id = made["id"];
    const auto path = create_upload(server.port(), secret, 1000, "commit");
    RawClient sending(server.port());
    sending.send(request_head("PATCH", path, patch_headers(secret, 0), 1000));
    sending.send(std::string(500, 'x'));
    EXPECT_EQ(
        RawClient(server.port())
            .request("DELETE", "/api/v1/tokens/" + token_id, {{"Authorization", "Bearer " + token}})
            .status,
        204);
    sending.send(std::string(500, 'x'));
    EXPECT_EQ(sending.receive()->status, 401);
    EXPECT_EQ(patch(path, 500, "x", {{"X-Unused", "1"}}).status, 409) << "its bytes are kept";
    EXPECT_EQ(server.request("GET", "/api/v1/dives", token).json()["items"].size(), 0U);
}

TEST_F(TusTest, AnotherProjectsUploadIsNotThere) {
    const auto path = create_upload(server.port(), token, 300'000);
    patch(path, 0, bytes.substr(0, 1000));
    const auto stranger = server.make_token("elsewhere", {"dives:write", "dives:read"});
    for (const char* method : {"HEAD", "GET", "DELETE"})
        EXPECT_EQ(RawClient(server.port()).request(method, path, tus_headers(stranger)).status, 404)
            << method;
    EXPECT_EQ(
        RawClient(server.port()).request("PATCH", path, patch_headers(stranger, 1000), "x").status,
        404);
    const auto id = path.substr(path.rfind('/') + 1);
    EXPECT_EQ(server.post_json("/api/v1/dives", stranger, {{"upload_id", id}}).status, 404);
    terminate(path);
    EXPECT_EQ(RawClient(server.port()).request("HEAD", path, tus_headers(stranger)).status, 404)
        << "not even that it was there";
    EXPECT_EQ(RawClient(server.port()).request("HEAD", path, {{"Tus-Resumable", "1.0.0"}}).status,
              401);
}

TEST_F(TusTest, TheAddressDoesNotDependOnWhatAProxyIsSaidToBe) {
    const auto made = create({{"Upload-Length", "10"},
                              {"X-Forwarded-Host", "evil.example"},
                              {"X-Forwarded-Proto", "https"},
                              {"Forwarded", "host=evil.example"}});
    EXPECT_TRUE(made.header("location").starts_with("/api/v1/uploads/")) << made.header("location");
}

}  // namespace
}  // namespace divemesh
