#include "tests/server/test_server.hpp"

#include <algorithm>
#include <fstream>
#include <random>
#include <soci/soci.h>

#include "schemas/content_hash.hpp"
#include "storage/job_store.hpp"
#include "storage/token_store.hpp"
#include "tests/ready_dive.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

int port_of(const std::string& url) { return std::stoi(url.substr(url.rfind(':') + 1)); }

}  // namespace

TestServer::TestServer(server::ServerConfig config) {
    config.listen = "127.0.0.1:0";
    if (config.data.empty()) config.data = folder_.path();
    if (config.min_free_bytes == server::ServerConfig().min_free_bytes)
        config.min_free_bytes = 1 << 20;
    server_ = std::make_unique<server::Server>(config);
    catalog_ = std::make_unique<storage::Catalog>(server_->config().catalog_url);
    blobs_ = storage::open_blob_store(server_->config().blobs_url);
    port_ = port_of(server_->url());
    thread_ = std::thread([this] { server_->run(); });
}

TestServer::~TestServer() { stop(); }

void TestServer::stop() {
    server_->stop();
    if (thread_.joinable()) thread_.join();
}

RawResponse TestServer::request(const std::string& method,
                                const std::string& target,
                                const std::string& token,
                                Headers headers,
                                std::string_view body) const {
    if (!token.empty()) headers.emplace_back("Authorization", "Bearer " + token);
    return RawClient(port_).request(method, target, headers, body);
}

RawResponse TestServer::post_json(const std::string& target,
                                  const std::string& token,
                                  const nlohmann::json& body) const {
    return request("POST", target, token, {{"Content-Type", "application/json"}}, body.dump());
}

std::string TestServer::make_token(const std::string& project,
                                   const std::vector<std::string>& scopes) {
    const bool pushes = std::find(scopes.begin(), scopes.end(), "sensor:push") != scopes.end();
    return storage::TokenStore(*catalog_)
        .create(
            {.name = "test", .project = project, .scopes = scopes, .sensor = pushes ? "rig" : ""})
        .secret;
}

std::string TestServer::make_dive(const std::string& project,
                                  const std::string& archive_sha256,
                                  const storage::IntakeResult& intake) {
    return make_ready_dive(*catalog_, project, archive_sha256, intake);
}

std::string TestServer::make_job(const std::string& project,
                                 const std::string& artifact_name,
                                 const std::string& bytes) {
    storage::NewJob wanted;
    wanted.project = project;
    wanted.dive_id = make_dive(project, sha256_hex(bytes + artifact_name));
    wanted.preset = "standard";
    storage::JobStore jobs(*catalog_);
    const Job job = jobs.enqueue(wanted).job;
    const auto claim = jobs.claim("test:1", 60s);
    const Artifact artifact = put_artifact(job.id, artifact_name, "file", bytes);
    jobs.append_log(claim->lease, "tracked 10 frames\n");
    jobs.succeed(claim->lease, {artifact});
    return job.id;
}

Artifact TestServer::put_artifact(const std::string& job_id,
                                  const std::string& name,
                                  const std::string& blob,
                                  const std::string& bytes) {
    const std::filesystem::path file = folder_ / "artifact";
    std::ofstream(file, std::ios::binary) << bytes;
    Artifact artifact{job_id,
                      name,
                      media_type_of(name),
                      sha256_hex(bytes),
                      static_cast<std::int64_t>(bytes.size()),
                      "jobs/" + job_id + "/1/" + blob};
    blobs_->put_file(artifact.blob, file);
    return artifact;
}

void TestServer::add_artifact(const std::string& job_id,
                              const std::string& name,
                              const std::string& bytes) {
    const Artifact artifact = put_artifact(job_id, name, sha256_hex(name).substr(0, 16), bytes);
    catalog_->transaction([&](soci::session& session) {
        session << "INSERT INTO artifacts (job_id, name, media_type, sha256, size_bytes, blob)"
                   " VALUES (:job, :name, :type, :sha256, :size, :blob)",
            soci::use(artifact.job_id), soci::use(artifact.name), soci::use(artifact.media_type),
            soci::use(artifact.sha256), soci::use(artifact.size_bytes), soci::use(artifact.blob);
    });
}

Headers tus_headers(const std::string& token, Headers more) {
    more.emplace_back("Authorization", "Bearer " + token);
    more.emplace_back("Tus-Resumable", "1.0.0");
    return more;
}

Headers patch_headers(const std::string& token, std::int64_t offset) {
    return tus_headers(token,
                       {{"Content-Type", "application/offset+octet-stream"},
                        {"Upload-Offset", std::to_string(offset)}});
}

std::string create_upload(int port,
                          const std::string& token,
                          std::int64_t length,
                          const std::string& metadata) {
    RawClient client(port);
    return create_upload(client, token, length, metadata);
}

std::string create_upload(RawClient& client,
                          const std::string& token,
                          std::int64_t length,
                          const std::string& metadata) {
    Headers headers = tus_headers(token, {{"Upload-Length", std::to_string(length)}});
    if (!metadata.empty()) headers.emplace_back("Upload-Metadata", metadata);
    const auto response = client.request("POST", "/api/v1/uploads", headers);
    if (response.status != 201) throw std::runtime_error(response.body);
    return response.header("location");
}

std::int64_t upload_offset(int port, const std::string& token, const std::string& path) {
    const auto response = RawClient(port).request("HEAD", path, tus_headers(token));
    return response.status == 200 ? std::stoll(response.header("upload-offset")) : -1;
}

std::string random_bytes(std::size_t size, unsigned seed) {
    std::mt19937_64 random(seed);
    std::string bytes(size, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    return bytes;
}

}  // namespace divemesh
