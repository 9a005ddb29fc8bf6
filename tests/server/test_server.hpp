#pragma once

#include <memory>
#include <string>
#include <thread>

#include "server/server.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "tests/server/raw_client.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh {

// A real server on a free port of loopback, in this process, with a data folder of its own.
class TestServer {
public:
    explicit TestServer(server::ServerConfig config = {});
    ~TestServer();
    TestServer(const TestServer&) = delete;
    TestServer& operator=(const TestServer&) = delete;

    int port() const { return port_; }
    const std::string& admin() const { return server_->first_token(); }
    std::filesystem::path data() const { return folder_.path(); }
    void stop();  // returns when it has
    void reload_certificate() { server_->reload_certificate(); }

    // One request over a connection of its own; a token "" is not sent.
    RawResponse request(const std::string& method,
                        const std::string& target,
                        const std::string& token,
                        Headers headers = {},
                        std::string_view body = {}) const;
    RawResponse post_json(const std::string& target,
                          const std::string& token,
                          const nlohmann::json& body) const;

    std::string make_token(const std::string& project, const std::vector<std::string>& scopes);
    // A dive that is ready, without the way through upload and worker.
    std::string make_dive(const std::string& project,
                          const std::string& archive_sha256,
                          const storage::IntakeResult& intake = {});
    // A succeeded reconstruction of a new dive with one artifact.
    std::string make_job(const std::string& project,
                         const std::string& artifact_name,
                         const std::string& bytes);

    storage::Catalog& catalog() { return *catalog_; }

private:
    TemporaryFolder folder_;
    std::unique_ptr<server::Server> server_;
    std::unique_ptr<storage::Catalog> catalog_;
    std::unique_ptr<storage::BlobStore> blobs_;
    int port_ = 0;
    std::thread thread_;
};

// Upload by hand: the headers of tus.
Headers tus_headers(const std::string& token, Headers more = {});
Headers patch_headers(const std::string& token, std::int64_t offset);
std::string create_upload(int port,
                          const std::string& token,
                          std::int64_t length,
                          const std::string& metadata = "");  // its path
std::int64_t upload_offset(int port, const std::string& token, const std::string& path);

std::string random_bytes(std::size_t size, unsigned seed = 1);

}  // namespace divemesh
