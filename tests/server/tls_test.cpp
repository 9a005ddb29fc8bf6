#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "api/client/download.hpp"
#include "api/client/event_stream.hpp"
#include "api/client/http_connection.hpp"
#include "api/client/tus_upload.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "tests/bytes_in_memory.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

namespace asio = boost::asio;
namespace client = api::client;
namespace fs = std::filesystem;

class TlsTest : public testing::Test {
protected:
    TlsTest() {
        make_certificate("first");
        config.tls_certificate = folder / "cert.pem";
        config.tls_key = folder / "key.pem";
    }

    void make_certificate(const std::string& name) {
        const std::string command =
            "openssl req -x509 -newkey rsa:2048 -nodes -days 2 -subj /CN=" + name +
            " -addext subjectAltName=IP:127.0.0.1 -keyout '" + (folder / "key.pem").string() +
            "' -out '" + (folder / "cert.pem").string() + "' 2>/dev/null";
        ASSERT_EQ(std::system(command.c_str()), 0);
    }

    struct Answer {
        std::string text;
        std::string common_name;
        std::string version;
    };
    static Answer ask(int port) {
        asio::io_context io;
        asio::ssl::context context(asio::ssl::context::tls_client);
        asio::ssl::stream<asio::ip::tcp::socket> stream(io, context);
        stream.next_layer().connect(
            {asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(port)});
        stream.handshake(asio::ssl::stream_base::client);
        asio::write(stream,
                    asio::buffer(std::string("GET /healthz/live HTTP/1.1\r\nHost: x\r\n"
                                             "Connection: close\r\n\r\n")));
        Answer answer;
        boost::system::error_code end;
        asio::read(stream, asio::dynamic_buffer(answer.text), end);
        char name[64] = "";
        X509* certificate = SSL_get_peer_certificate(stream.native_handle());
        X509_NAME_get_text_by_NID(
            X509_get_subject_name(certificate), NID_commonName, name, sizeof name);
        X509_free(certificate);
        answer.common_name = name;
        answer.version = SSL_get_version(stream.native_handle());
        EXPECT_EQ(end, asio::error::eof);  // said goodbye, not cut off
        return answer;
    }

    TemporaryFolder folder;
    server::ServerConfig config;
};

TEST_F(TlsTest, ServesOverTlsAndReadsItsCertificateAnew) {
    TestServer server(config);
    const Answer first = ask(server.port());
    EXPECT_TRUE(first.text.starts_with("HTTP/1.1 200"));
    EXPECT_EQ(first.common_name, "first");
    EXPECT_EQ(first.version, "TLSv1.3");
    make_certificate("second");
    EXPECT_EQ(ask(server.port()).common_name, "first");
    server.reload_certificate();
    EXPECT_EQ(ask(server.port()).common_name, "second");
    std::ofstream(folder / "key.pem") << "no key";
    server.reload_certificate();
    EXPECT_EQ(ask(server.port()).common_name, "second");
}

class TlsClientTest : public TlsTest {
protected:
    client::Account account(const std::string& host = "127.0.0.1") {
        const auto url = "https://" + host + ":" + std::to_string(server.port());
        return {client::parse_server_url(url), server.admin()};
    }
    client::Account believer() {
        auto believer = account();
        believer.server.ca_file = folder / "cert.pem";
        return believer;
    }
    static std::optional<ErrorCode> refusal(const client::Account& account) {
        try {
            client::RestClient(account).get("/api/v1/dives");
        } catch (const Error& error) {
            return error.code();
        }
        return std::nullopt;
    }

    TestServer server{config};
    TemporaryFolder states;
};

TEST_F(TlsClientTest, UploadsAndWatches) {
    const std::string whole = random_bytes(3'000'000);
    client::EventStream events(believer(), 0);
    BytesInMemory source(whole);
    client::TusSettings settings;
    settings.chunk_bytes = 1 << 20;
    const client::UploadState state(states.path(), believer().server.url(), "hash");
    const auto path =
        client::upload_by_tus(believer(), source, {{"commit", ""}}, state, {}, settings);

    const auto upload = client::RestClient(believer()).get(path);
    EXPECT_EQ(upload["offset_bytes"], 3'000'000);
    EXPECT_TRUE(events.next(std::chrono::seconds(10)).has_value());
}

TEST_F(TlsClientTest, DownloadsOverTls) {
    const std::string bytes = random_bytes(5'000'000);
    const std::string job = server.make_job("default", "mesh.glb", bytes);
    Artifact artifact;
    artifact.job_id = job;
    artifact.name = "mesh.glb";
    artifact.sha256 = sha256_hex(bytes);
    artifact.size_bytes = std::ssize(bytes);
    client::download_artifacts(believer(), {artifact}, folder / "model", {});
    std::ostringstream file;
    file << std::ifstream(folder / "model" / "mesh.glb", std::ios::binary).rdbuf();
    EXPECT_EQ(sha256_hex(file.str()), sha256_hex(bytes));
}

TEST_F(TlsClientTest, LeavesAServerThatDoesNotProveToBeTheOne) {
    EXPECT_EQ(refusal(account()), ErrorCode::Forbidden) << "signed by nobody it knows";
    auto other_name = account("localhost");
    other_name.server.ca_file = folder / "cert.pem";
    EXPECT_EQ(refusal(other_name), ErrorCode::Forbidden);
    auto no_file = account();
    no_file.server.ca_file = folder / "missing.pem";
    EXPECT_EQ(refusal(no_file), ErrorCode::InvalidArgument);
}

// RFC 6797, 7.2: never over plain HTTP.
TEST_F(TlsTest, TellsBrowsersToStayWithTlsIfThatIsWanted) {
    EXPECT_EQ(ask(TestServer(config).port()).text.find("Strict-Transport-Security"),
              std::string::npos);
    config.hsts = std::chrono::hours(24);
    EXPECT_NE(ask(TestServer(config).port()).text.find("Strict-Transport-Security: max-age=86400"),
              std::string::npos);
    config.tls_certificate.clear();
    config.tls_key.clear();
    EXPECT_THROW(server::check_config(config), Error);
    EXPECT_THROW(server::run_server(config), Error);  // serves nothing either
    EXPECT_EQ(
        TestServer(config).request("GET", "/healthz/live", "").header("strict-transport-security"),
        "");
}

TEST_F(TlsTest, TheCookieOfASessionIsForTlsAlone) {
    const TestServer server(config);
    auto address = client::parse_server_url("https://127.0.0.1:" + std::to_string(server.port()));
    address.ca_file = folder / "cert.pem";
    client::HttpConnection connection(address, std::chrono::seconds(20));
    const auto begun = connection.send(
        {"POST", "/api/v1/session", {{"Authorization", "Bearer " + server.admin()}}, ""});
    EXPECT_EQ(begun.status, 201) << begun.body;
    const std::string set = begun.header("set-cookie");
    EXPECT_TRUE(set.ends_with("; Secure")) << set;
    ASSERT_TRUE(set.starts_with("__Host-divemesh_session=")) << set;
    EXPECT_NE(set.find("; Path=/;"), std::string::npos) << set;
    const std::string secret = set.substr(set.find('='), set.find(';') - set.find('='));
    const auto status = [&](const std::string& name) {
        return connection.send({"GET", "/api/v1/session", {{"Cookie", name + secret}}, ""}).status;
    };
    EXPECT_EQ(status("__Host-divemesh_session"), 200);
    EXPECT_EQ(status("divemesh_session"), 401) << "any host of the same site can set this one";
}

// RFC 9325, 4.2: with TLS 1.2 only what has forward secrecy and authenticated encryption.
TEST_F(TlsTest, OldVersionsAndWeakCiphersAreRefused) {
    TestServer server(config);
    const auto connects = [&](int version, const char* ciphers) {
        asio::io_context io;
        asio::ssl::context context(asio::ssl::context::tls_client);
        SSL_CTX_set_security_level(context.native_handle(), 0);
        SSL_CTX_set_min_proto_version(context.native_handle(), version);
        SSL_CTX_set_max_proto_version(context.native_handle(), version);
        EXPECT_EQ(SSL_CTX_set_cipher_list(context.native_handle(), ciphers), 1);
        asio::ssl::stream<asio::ip::tcp::socket> stream(io, context);
        stream.next_layer().connect(
            {asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(server.port())});
        boost::system::error_code failure;
        stream.handshake(asio::ssl::stream_base::client, failure);
        return !failure;
    };
    EXPECT_TRUE(connects(TLS1_2_VERSION, "ECDHE-RSA-AES128-GCM-SHA256"));
    EXPECT_TRUE(connects(TLS1_2_VERSION, "ECDHE-RSA-CHACHA20-POLY1305"));
    EXPECT_FALSE(connects(TLS1_2_VERSION, "AES128-GCM-SHA256")) << "no forward secrecy";
    EXPECT_FALSE(connects(TLS1_2_VERSION, "ECDHE-RSA-AES128-SHA")) << "CBC";
    EXPECT_FALSE(connects(TLS1_1_VERSION, "ALL:@SECLEVEL=0"));
}

TEST_F(TlsTest, WhoSpeaksNoTlsIsLeftAlone) {
    config.timeouts.header = std::chrono::milliseconds(500);
    TestServer server(config);
    RawClient plain(server.port());
    plain.send("GET /healthz/live HTTP/1.1\r\n\r\n");
    EXPECT_EQ(plain.read_available().find("HTTP/1.1 200"), std::string::npos);
    RawClient silent(server.port());
    EXPECT_TRUE(silent.at_end());
    EXPECT_TRUE(ask(server.port()).text.starts_with("HTTP/1.1 200"));
}

TEST_F(TlsTest, RefusesACertificateThatCannotBeUsed) {
    const auto refused = [&] {
        try {
            server::check_config(config);
        } catch (const Error& error) {
            return error.code() == ErrorCode::InvalidArgument;
        }
        return false;
    };
    EXPECT_FALSE(refused());
    config.tls_key.clear();
    EXPECT_TRUE(refused());
    config.tls_key = folder / "missing.pem";
    EXPECT_TRUE(refused());
    fs::copy_file(folder / "key.pem", folder / "old.pem");
    make_certificate("other");
    config.tls_key = folder / "old.pem";
    EXPECT_TRUE(refused());
}

TEST(CheckConfigTest, NamesWhatCouldNotBeServed) {
    const auto refused = [](const auto& change) {
        server::ServerConfig config;
        change(config);
        try {
            server::check_config(config);
        } catch (const Error&) {
            return true;
        }
        return false;
    };
    EXPECT_FALSE(refused([](auto&) {}));
    EXPECT_TRUE(refused([](auto& config) { config.listen = "nowhere"; }));
    EXPECT_TRUE(refused([](auto& config) {
        config.listen = "0.0.0.0:80";
        config.no_auth = true;
    }));
    EXPECT_TRUE(refused([](auto& config) { config.allowed_origins = {"https://lab.example/"}; }));
    EXPECT_TRUE(refused([](auto& config) { config.allowed_origins = {"*"}; }));
    EXPECT_TRUE(refused([](auto& config) { config.webhook_networks = {"10.0.0.0/99"}; }));
}

}  // namespace
}  // namespace divemesh
