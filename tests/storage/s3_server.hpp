#pragma once

#include <memory>
#include <optional>
#include <string>

#include "storage/sigv4.hpp"
#include "tests/end_to_end/process.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::storage {

// An object store on loopback, which the destructor ends. It has one bucket, "dives".
class S3Server {
public:
    // Returns nullptr where its packages are missing: npm ci in tests/end_to_end/js.
    // It compares no signatures.
    static std::unique_ptr<S3Server> start_s3rver();
    // Returns nullptr where Ceph is not installed.
    static std::unique_ptr<S3Server> start_ceph(int num_gibibytes = 4);
    static S3Server* shared_ceph();  // one for all tests of a process
    ~S3Server();
    S3Server(const S3Server&) = delete;
    S3Server& operator=(const S3Server&) = delete;

    const S3Credentials& credentials() const { return credentials_; }
    int port() const { return port_; }
    // Returns the address of a store below a prefix of the bucket, by way of another port if given.
    std::string url(const std::string& prefix, int port = 0) const;

private:
    explicit S3Server(S3Credentials credentials);
    void start(const std::vector<std::string>& command);
    void make_bucket() const;

    S3Credentials credentials_;
    int port_ = 0;
    TemporaryFolder folder_;
    std::optional<Process> process_;
};

int free_port();

}  // namespace divemesh::storage
