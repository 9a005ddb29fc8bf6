// Content-Encoding: gzip, held against gzip(1), and archives of artifacts, held against unzip(1).
#include "api/content_coding.hpp"

#include <cstdio>
#include <fstream>
#include <gmock/gmock.h>

#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

std::string output_of(const std::string& command) {
    FILE* pipe = popen(command.c_str(), "r");
    std::string output;
    char buffer[4096];
    for (std::size_t size; (size = fread(buffer, 1, sizeof buffer, pipe)) > 0;)
        output.append(buffer, size);
    EXPECT_EQ(pclose(pipe), 0) << command;
    return output;
}

class ContentCodingTest : public testing::Test {
protected:
    RawResponse get(const std::string& target, Headers headers = {}) {
        return server.request("GET", target, server.admin(), std::move(headers));
    }
    RawResponse get_gzip(const std::string& target, Headers headers = {}) {
        headers.emplace_back("Accept-Encoding", "gzip, deflate, br");
        return get(target, std::move(headers));
    }
    std::string write(const std::string& name, const std::string& bytes) {
        const auto file = folder / name;
        std::ofstream(file, std::ios::binary) << bytes;
        return file.string();
    }
    std::string unpacked(const std::string& bytes) {
        return output_of("gzip -dc " + write("answer.gz", bytes));
    }
    std::string artifact(const std::string& name, const std::string& bytes) {
        return "/api/v1/jobs/" + server.make_job("default", name, bytes) + "/artifacts/" + name;
    }

    TemporaryFolder folder;
    TestServer server;
};

std::string some_ply() {
    std::string ply = "ply\nformat ascii 1.0\n";
    for (int i = 0; i < 100'000; ++i) ply += std::to_string(i % 977) + " 0.25 0.5\n";
    return ply;
}

TEST_F(ContentCodingTest, JsonIsCompressedForWhoTakesIt) {
    const auto plain = get("/api/v1/options");
    const auto packed = get_gzip("/api/v1/options");
    EXPECT_EQ(plain.header("content-encoding"), "");
    EXPECT_EQ(plain.header("vary"), "Accept-Encoding");
    EXPECT_EQ(packed.header("content-encoding"), "gzip");
    EXPECT_EQ(packed.header("vary"), "Accept-Encoding");
    EXPECT_LT(packed.body.size(), plain.body.size() / 3);
    EXPECT_EQ(unpacked(packed.body), plain.body);
    const auto head =
        server.request("HEAD", "/api/v1/options", server.admin(), {{"Accept-Encoding", "gzip"}});
    EXPECT_EQ(head.header("content-length"), std::to_string(packed.body.size()));
}

TEST_F(ContentCodingTest, EachCodingHasATagAndBothNameTheSame) {
    const std::string plain = get("/api/v1/options").header("etag");
    const std::string packed = get_gzip("/api/v1/options").header("etag");
    EXPECT_NE(plain, packed);
    for (const std::string& tag : {plain, packed}) {
        const auto known = get_gzip("/api/v1/options", {{"If-None-Match", tag}});
        EXPECT_EQ(known.status, 304);
        EXPECT_EQ(known.header("etag"), tag);
        EXPECT_EQ(known.header("vary"), "Accept-Encoding");
    }
    const std::string dive = "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a'));
    const Headers json = {{"Content-Type", "application/json"}};
    server.request(
        "PATCH", dive, server.admin(), json, R"({"notes": ")" + std::string(2000, 'x') + "\"}");
    const std::string tag = get_gzip(dive).header("etag");
    EXPECT_TRUE(tag.ends_with("-gzip\""));
    const auto edited = server.request("PATCH",
                                       dive,
                                       server.admin(),
                                       {{"Content-Type", "application/json"}, {"If-Match", tag}},
                                       R"({"site": "Reef"})");
    EXPECT_EQ(edited.status, 200) << edited.body;
}

TEST_F(ContentCodingTest, AMeshIsCompressedWhileItIsSent) {
    const std::string ply = some_ply();
    const std::string path = artifact("mesh.ply", ply);
    const auto packed = get_gzip(path);
    EXPECT_EQ(packed.header("content-encoding"), "gzip");
    EXPECT_EQ(packed.header("transfer-encoding"), "chunked");
    EXPECT_EQ(packed.header("repr-digest"), "");
    EXPECT_LT(packed.body.size(), ply.size() / 3);
    EXPECT_EQ(unpacked(packed.body), ply);
    const auto plain = get(path);
    EXPECT_EQ(plain.body, ply);
    EXPECT_EQ(plain.header("content-length"), std::to_string(ply.size()));
}

TEST_F(ContentCodingTest, ARangeIsOfTheBytesAsTheyAre) {
    const std::string ply = some_ply();
    const std::string path = artifact("mesh.ply", ply);
    const std::string packed = get_gzip(path).header("etag");
    const auto part = get_gzip(path, {{"Range", "bytes=4-9"}});
    EXPECT_EQ(part.status, 206);
    EXPECT_EQ(part.body, ply.substr(4, 6));
    EXPECT_EQ(part.header("content-encoding"), "");
    // The client has bytes of the compressed answer: these do not go on in the middle of the file.
    const auto other = get_gzip(path, {{"Range", "bytes=4-9"}, {"If-Range", packed}});
    EXPECT_EQ(other.status, 200);
    EXPECT_EQ(other.body, ply);
}

TEST_F(ContentCodingTest, WhatIsShortCompressedAlreadyOrSecretIsLeftAlone) {
    EXPECT_EQ(get_gzip(artifact("metrics.json", "{}")).header("content-encoding"), "");
    const auto glb = get_gzip(artifact("mesh.glb", std::string(10'000, 'x')));
    EXPECT_EQ(glb.header("content-encoding"), "");
    EXPECT_EQ(glb.header("vary"), "");
    const auto secret =
        server.request("POST",
                       "/api/v1/tokens",
                       server.admin(),
                       {{"Content-Type", "application/json"}, {"Accept-Encoding", "gzip"}},
                       R"({"name": "x", "scopes": ["dives:read"]})");
    EXPECT_EQ(secret.status, 201);
    EXPECT_EQ(secret.header("content-encoding"), "");
}

TEST(AcceptEncodingTest, IsReadAsRfc9110Says) {
    for (const char* taken :
         {"gzip", "GZIP", "x-gzip", "br, gzip;q=0.5", "*", "*;q=0.1", "deflate,gzip ; q=1"})
        EXPECT_TRUE(api::accepts_gzip(taken)) << taken;
    for (const char* refused :
         {"", "identity", "br", "gzip;q=0", "gzip; q=0.000", "*;q=0", "*, gzip;q=0", "gzipped"})
        EXPECT_FALSE(api::accepts_gzip(refused)) << refused;
}

class ArchiveTest : public ContentCodingTest {
protected:
    // Returns the path of the archive of a job with these artifacts.
    std::string job_with(const std::map<std::string, std::string>& files) {
        const auto& [name, bytes] = *files.begin();
        const std::string job = server.make_job("default", name, bytes);
        for (auto file = std::next(files.begin()); file != files.end(); ++file)
            server.add_artifact(job, file->first, file->second);
        return "/api/v1/jobs/" + job + "/artifacts.zip";
    }
};

TEST_F(ArchiveTest, HoldsTheArtifactsAsTheyAre) {
    const std::map<std::string, std::string> files = {{"keyframes/000001.jpg", random_bytes(5'000)},
                                                      {"mesh.ply", some_ply()},
                                                      {"empty.txt", ""},
                                                      {"metrics.json", "{}"}};
    const std::string path = job_with(files);
    const auto answer = get(path);
    ASSERT_EQ(answer.status, 200);
    EXPECT_EQ(answer.header("content-type"), "application/zip");
    EXPECT_TRUE(answer.header("content-disposition").starts_with("attachment"));
    const std::string zip = write("all.zip", answer.body);
    EXPECT_THAT(output_of("unzip -t " + zip), testing::HasSubstr("No errors"));
    for (const auto& [name, bytes] : files)
        EXPECT_EQ(output_of("unzip -p " + zip + " " + name), bytes) << name;
    EXPECT_LT(answer.body.size(), files.at("mesh.ply").size());
}

TEST_F(ArchiveTest, HoldsTheNamedOnesAlone) {
    const std::string path =
        job_with({{"mesh.ply", "ply"}, {"metrics.json", "{}"}, {"a.csv", "1"}});
    const std::string zip =
        write("some.zip", get(path + "?names=metrics.json,mesh.ply,metrics.json").body);
    EXPECT_EQ(output_of("unzip -Z1 " + zip), "metrics.json\nmesh.ply\n");
    const auto unknown = get(path + "?names=mesh.ply,mesh.obj");
    EXPECT_EQ(unknown.status, 404);
    EXPECT_NE(unknown.body.find("mesh.obj"), std::string::npos);
    EXPECT_EQ(get("/api/v1/jobs/job_none/artifacts.zip").status, 404);
}

TEST_F(ArchiveTest, ABlobThatIsGoneCutsTheArchiveOff) {
    const std::string path = job_with({{"a.ply", some_ply()}, {"b.ply", some_ply()}});
    std::filesystem::remove_all(server.data() / "blobs" / "blobs" / "jobs");
    EXPECT_THROW(get(path), std::runtime_error) << "there is no last chunk";
}

TEST(LogTest, IsReadFromAnOffsetOn) {
    TestServer server;
    const std::string job = "/api/v1/jobs/" + server.make_job("default", "mesh.glb", "glTF");
    for (const std::string& log : {job + "/log", job + "/attempts/1/log"}) {
        const auto get = [&](const std::string& query) {
            return server.request("GET", log + query, server.admin());
        };
        EXPECT_EQ(get("").body, "tracked 10 frames\n");
        EXPECT_EQ(get("?from=8").body, "10 frames\n");
        EXPECT_EQ(get("?from=1000").body, "");
        EXPECT_EQ(get("?from=-1").status, 400);
    }
}

}  // namespace
}  // namespace divemesh
