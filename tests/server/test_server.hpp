#pragma once

#include <memory>
#include <string>
#include <thread>

#include "schemas/artifact.hpp"
#include "server/server.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "tests/server/raw_client.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh {

// A real server in this process, on a free port of loopback, with a temporary data folder.
class TestServer {
public:
    explicit TestServer(server::ServerConfig config = {});
    ~TestServer();
    TestServer(const TestServer&) = delete;
    TestServer& operator=(const TestServer&) = delete;

    int port() const { return port_; }
    const std::string& admin() const { return server_->first_token(); }
    std::filesystem::path data() const { return folder_.path(); }
    void stop();  // returns when the server has stopped
    void reload_certificate() { server_->reload_certificate(); }

    // Sends one request over a new connection; sends no token if it is "".
    RawResponse request(const std::string& method,
                        const std::string& target,
                        const std::string& token,
                        Headers headers = {},
                        std::string_view body = {}) const;
    RawResponse post_json(const std::string& target,
                          const std::string& token,
                          const nlohmann::json& body) const;

    std::string make_token(const std::string& project, const std::vector<std::string>& scopes);
    // Creates a dive in state ready, without upload and worker, and returns its id.
    std::string make_dive(const std::string& project,
                          const std::string& archive_sha256,
                          const storage::IntakeResult& intake = {});
    // Creates a succeeded reconstruction of a new dive with one artifact, and returns its id.
    std::string make_job(const std::string& project,
                         const std::string& artifact_name,
                         const std::string& bytes);

    // Adds another artifact to such a job.
    void add_artifact(const std::string& job_id, const std::string& name, const std::string& bytes);

    storage::Catalog& catalog() { return *catalog_; }

private:
    Artifact put_artifact(const std::string& job_id,
                          const std::string& name,
                          const std::string& blob,
                          const std::string& bytes);

    TemporaryFolder folder_;
    std::unique_ptr<server::Server> server_;
    std::unique_ptr<storage::Catalog> catalog_;
    std::unique_ptr<storage::BlobStore> blobs_;
    int port_ = 0;
    std::thread thread_;
};

// The headers of tus, for uploads by single requests.
Headers tus_headers(const std::string& token, Headers more = {});
Headers patch_headers(const std::string& token, std::int64_t offset);
std::string create_upload(int port,
                          const std::string& token,
                          std::int64_t length,
                          const std::string& metadata = "");  // returns its path
// The same, on a connection that stays open.
std::string create_upload(RawClient& client,
                          const std::string& token,
                          std::int64_t length,
                          const std::string& metadata = "");
std::int64_t upload_offset(int port, const std::string& token, const std::string& path);

std::string random_bytes(std::size_t size, unsigned seed = 1);

}  // namespace divemesh
