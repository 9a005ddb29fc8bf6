#pragma once

#include <gtest/gtest.h>

#include "schemas/content_hash.hpp"
#include "storage/dive_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {

// A server, its administrator, and something to upload.
class TusTest : public testing::Test {
protected:
    explicit TusTest(const server::ServerConfig& config = {}) : server(config) {}

    RawResponse patch(const std::string& path,
                      std::int64_t offset,
                      std::string_view body,
                      const Headers& more = {}) {
        Headers headers = patch_headers(token, offset);
        headers.insert(headers.end(), more.begin(), more.end());
        return RawClient(server.port()).request("PATCH", path, headers, body);
    }
    RawResponse create(Headers headers, std::string_view body = {}) {
        return RawClient(server.port())
            .request("POST", "/api/v1/uploads", tus_headers(token, std::move(headers)), body);
    }
    RawResponse head(const std::string& path) {
        return RawClient(server.port()).request("HEAD", path, tus_headers(token));
    }
    RawResponse terminate(const std::string& path) {
        return RawClient(server.port()).request("DELETE", path, tus_headers(token));
    }
    // Creates a complete partial upload and returns its path.
    std::string make_part(std::string_view content) {
        const auto made = create({{"Upload-Length", std::to_string(content.size())},
                                  {"Upload-Concat", "partial"},
                                  {"Content-Type", "application/offset+octet-stream"}},
                                 content);
        EXPECT_EQ(made.status, 201) << made.body;
        return made.header("location");
    }
    // Returns the header Upload-Concat of the final upload.
    static std::string final_of(const std::vector<std::string>& parts) {
        std::string concat = "final;";
        for (const auto& part : parts) concat += (concat.ends_with(';') ? "" : " ") + part;
        return concat;
    }
    std::string archive_of(const std::string& dive_id) {
        const auto dive = storage::DiveStore(server.catalog()).get(dive_id);
        const auto reader =
            storage::open_blob_store((server.data() / "blobs").string())->open(dive.blob);
        std::string stored(static_cast<std::size_t>(reader->size_bytes()), '\0');
        reader->read_at(0, stored);
        return stored;
    }
    std::size_t num_staged_files() const {
        std::size_t count = 0;
        for (const auto& entry :
             std::filesystem::recursive_directory_iterator(server.data() / "blobs" / "staged"))
            if (entry.is_regular_file()) ++count;
        return count;
    }

    TestServer server;
    const std::string token = server.admin();
    const std::string bytes = random_bytes(300'000);
};

}  // namespace divemesh
