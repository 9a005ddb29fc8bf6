#include <gtest/gtest.h>

#include <fcntl.h>
#include <fstream>
#include <soci/soci.h>
#include <sys/stat.h>
#include <unistd.h>

#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"
#include "server/listen_address.hpp"
#include "server/server.hpp"
#include "storage/event_store.hpp"
#include "storage/token_store.hpp"
#include "storage/upload_store.hpp"
#include "tests/ready_dive.hpp"
#include "tests/server/server_process.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh::server {
namespace {

namespace fs = std::filesystem;

ServerConfig config_at(const TemporaryFolder& data, const std::string& listen) {
    ServerConfig config;
    config.listen = listen;
    config.data = data.path();
    return config;
}

ErrorCode refusal_of(const ServerConfig& config) {
    try {
        const Server server(config);
    } catch (const Error& error) {
        return error.code();
    }
    throw std::runtime_error("the server started");
}

TEST(StartTest, MakesOneTokenThatItsOwnerAloneCanRead) {
    const TemporaryFolder data;
    std::string secret;
    {
        const Server server(config_at(data, "127.0.0.1:0"));
        secret = server.first_token();
    }
    ASSERT_TRUE(secret.starts_with("dm_"));
    std::ifstream file(data / "admin.token");
    std::string written;
    file >> written;
    EXPECT_EQ(written, secret);
    EXPECT_EQ(fs::status(data / "admin.token").permissions(),
              fs::perms::owner_read | fs::perms::owner_write);
    const Server again(config_at(data, "127.0.0.1:0"));
    EXPECT_EQ(again.first_token(), "");
}

TEST(StartTest, ANewDataFolderIsClosedToOtherUsersOfTheMachine) {
    const TemporaryFolder folder;
    server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    config.data = folder / "data";
    const mode_t umask_before = umask(0);
    { const server::Server server(config); }
    umask(umask_before);
    EXPECT_EQ(fs::status(folder / "data").permissions() & fs::perms::others_all, fs::perms::none);
    fs::permissions(folder / "data", fs::perms::others_read, fs::perm_options::add);
    { const server::Server again(config); }
    EXPECT_EQ(fs::status(folder / "data").permissions() & fs::perms::others_all,
              fs::perms::others_read)
        << "what the operator has set stays";
}

TEST(StartTest, DoesNotServeWithoutTheBlobsOfItsCatalog) {
    const TemporaryFolder folder;
    server::ServerConfig config;
    config.listen = "127.0.0.1:0";
    config.data = folder.path();
    { const server::Server first(config); }
    std::filesystem::rename(folder / "blobs", folder / "away");
    EXPECT_THROW(server::Server{config}, Error);
    EXPECT_FALSE(std::filesystem::exists(folder / "blobs")) << "a store was made";
    storage::open_blob_store((folder / "blobs").string());  // another one
    EXPECT_THROW(server::Server{config}, Error);
    std::filesystem::remove_all(folder / "blobs");
    std::filesystem::rename(folder / "away", folder / "blobs");
    const server::Server again(config);
}

// Logs are kept and copied, so they must not contain the token.
TEST(StartTest, TheLogNamesTheFileOfTheFirstTokenAndNotTheToken) {
    const TemporaryFolder data;
    const std::string log = (data / "log").string();
    {
        const FileDescriptor own(dup(STDERR_FILENO));
        const FileDescriptor file(open(log.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
        ASSERT_EQ(dup2(file.get(), STDERR_FILENO), STDERR_FILENO);
        { ServerProcess server(data / "data"); }
        ASSERT_EQ(dup2(own.get(), STDERR_FILENO), STDERR_FILENO);
    }
    const std::string secret = read_token(data / "data");
    ASSERT_TRUE(secret.starts_with("dm_"));
    std::ifstream lines(log);
    int num_named = 0;
    for (std::string line; std::getline(lines, line);) {
        EXPECT_EQ(line.find(secret), std::string::npos);
        ASSERT_TRUE(nlohmann::json::accept(line)) << line;
        const auto fields = nlohmann::json::parse(line)["data"];
        num_named += fields.value("file", "") == (data / "data/admin.token").string() ? 1 : 0;
    }
    EXPECT_EQ(num_named, 1);
}

TEST(StartTest, TheFirstTokenIsNotedOnce) {
    const TemporaryFolder data;
    for (int i = 0; i < 2; ++i) const Server server(config_at(data, "127.0.0.1:0"));
    storage::Catalog catalog("sqlite://" + (data / "catalog.db").string());
    const auto events = storage::EventStore(catalog).since(0, "", 100);
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].topic, "audit");
    EXPECT_EQ(events[0].data["path"], "first token");
}

TEST(StartTest, DoesNotServeTheNetworkWithoutATokenOrWithoutAskingForOne) {
    const TemporaryFolder data;
    EXPECT_EQ(refusal_of(config_at(data, "0.0.0.0:0")), ErrorCode::InvalidArgument);
    EXPECT_FALSE(fs::exists(data / "admin.token"));
    auto open = config_at(data, "0.0.0.0:0");
    open.no_auth = true;
    EXPECT_EQ(refusal_of(open), ErrorCode::InvalidArgument);
    { const Server local(config_at(data, "127.0.0.1:0")); }
    EXPECT_EQ(refusal_of(open), ErrorCode::InvalidArgument);
}

TEST(StartTest, OnLoopbackNoAuthIsAllowed) {
    ServerConfig config;
    config.no_auth = true;
    TestServer server(config);
    EXPECT_EQ(server.request("GET", "/api/v1/dives", "").status, 200);
    EXPECT_FALSE(fs::exists(server.data() / "admin.token"));
}

// Found by fuzzing: the page asks for one wherever it is served.
TEST(StartTest, WithoutAuthenticationAOneShotTokenIsStillGiven) {
    ServerConfig config;
    config.no_auth = true;
    TestServer server(config);
    const std::string path =
        "/api/v1/jobs/" + server.make_job("default", "mesh.glb", "glTF") + "/artifacts/mesh.glb";
    const auto made = server.post_json("/api/v1/one_shot_tokens", "", {{"path", path}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string secret = made.json()["secret"];
    EXPECT_EQ(server.request("GET", path + "?one_shot=" + secret, "").body, "glTF");
}

TEST(StartTest, RefusesAnAddressThatIsNoneOrIsTaken) {
    const TemporaryFolder data;
    for (const char* listen : {"",
                               "8080",
                               "127.0.0.1",
                               "127.0.0.1:",
                               "127.0.0.1:x",
                               "host:80",
                               "127.0.0.1:70000",
                               "127.0.0.1:80 "})
        EXPECT_EQ(refusal_of(config_at(data, listen)), ErrorCode::InvalidArgument) << listen;
    const Server server(config_at(data, "127.0.0.1:0"));
    const std::string taken = server.url().substr(std::string("http://").size());
    const TemporaryFolder other;
    EXPECT_EQ(refusal_of(config_at(other, taken)), ErrorCode::Unavailable);
}

TEST(StartTest, ReadsBothFamiliesOfAddresses) {
    EXPECT_TRUE(parse_listen_address("[::1]:80").address().is_loopback());
    EXPECT_EQ(url_of(parse_listen_address("[::1]:80")), "http://[::1]:80");
    EXPECT_EQ(url_of(parse_listen_address("localhost:81")), "http://127.0.0.1:81");
}

// Entered, received, and the server is killed before the dive.
std::string leave_pending_dive(const ServerConfig& config,
                               const std::string& token_id,
                               const std::string& metadata,
                               bool is_noted = true) {
    storage::Catalog catalog(config.catalog_url);
    const auto blobs = storage::open_blob_store(config.blobs_url);
    Upload upload;
    upload.project = "default";
    upload.token_id = token_id;
    upload.length_bytes = 5;
    upload.metadata = metadata;
    upload = storage::UploadStore(catalog).create(upload);
    const auto staged = blobs->open_staged(upload.blob);
    staged->write(std::string_view("hello"));
    staged->flush();
    if (is_noted) storage::UploadStore(catalog).advance(upload.id, 5);
    return upload.id;
}

TEST(StartTest, MakesPendingDivesOfAKilledServerIfTheirTokensAreValid) {
    const TemporaryFolder data;
    const auto config = config_at(data, "127.0.0.1:0");
    std::string wrong;
    std::string revoked;
    std::string good;
    std::string unnoted;
    {
        const Server server(config);
        storage::Catalog catalog(server.config().catalog_url);
        storage::TokenStore tokens(catalog);
        const auto lost = tokens.create({.name = "lost", .scopes = {"dives:write"}}).token.id;
        const auto kept = tokens.create({.name = "kept", .scopes = {"dives:write"}}).token.id;
        wrong = leave_pending_dive(
            server.config(), kept, "commit,sha256 " + base64(std::string(64, '0')));
        revoked = leave_pending_dive(server.config(), lost, "commit");
        tokens.revoke(lost);
        good = leave_pending_dive(server.config(), kept, "commit");
        unnoted = leave_pending_dive(server.config(), kept, "commit", false);
    }
    Server server(config);
    std::thread running([&] { server.run(); });
    storage::Catalog catalog(server.config().catalog_url);
    storage::UploadStore uploads(catalog);
    for (int i = 0; i < 500 && uploads.get(unnoted).dive_id.empty(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    server.stop();
    running.join();
    EXPECT_FALSE(uploads.get(good).dive_id.empty());
    EXPECT_EQ(uploads.get(unnoted).dive_id, uploads.get(good).dive_id) << "the same bytes";
    EXPECT_TRUE(uploads.get(revoked).dive_id.empty());
    EXPECT_FALSE(uploads.get(revoked).end) << "its bytes are kept";
    EXPECT_EQ(uploads.get(wrong).end, UploadEnd::Terminated);
}

TEST(StartTest, APendingDiveIsMadeOnceTheQuotaAllowsIt) {
    const TemporaryFolder data;
    auto config = config_at(data, "127.0.0.1:0");
    config.max_project_dives = 1;
    config.timeouts.pending_dives = std::chrono::milliseconds(20);
    std::string pending;
    std::string token;
    {
        const Server server(config);
        storage::Catalog catalog(server.config().catalog_url);
        token = storage::TokenStore(catalog)
                    .create({.name = "boat", .scopes = {"dives:write"}})
                    .token.id;
        make_ready_dive(catalog, "default", std::string(64, 'a'));
        pending = leave_pending_dive(server.config(), token, "commit");
    }
    Server server(config);
    std::thread running([&] { server.run(); });
    storage::Catalog catalog(server.config().catalog_url);
    storage::UploadStore uploads(catalog);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));  // some attempts
    EXPECT_TRUE(uploads.get(pending).dive_id.empty());
    catalog.transaction(
        [](soci::session& session) { session << "UPDATE dives SET project = 'elsewhere'"; });
    for (int i = 0; i < 1000 && uploads.get(pending).dive_id.empty(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    server.stop();
    running.join();
    EXPECT_FALSE(uploads.get(pending).dive_id.empty());
}

}  // namespace
}  // namespace divemesh::server
