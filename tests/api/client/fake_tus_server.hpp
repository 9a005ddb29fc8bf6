#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <thread>

#include "schemas/file_descriptor.hpp"

namespace divemesh {

// A tus server for one upload, on a free port, that produces the faults of a script.
class FakeTusServer {
public:
    // The fault of one request; requests after the end of the script are served correctly.
    struct Fault {
        int status = 0;               // > 0: the answer has this status and no bytes are stored
        std::int64_t cut_after = -1;  // >= 0: the connection ends after so many bytes of a body
        bool silent = false;          // the request is never answered
        bool by_proxy = false;        // the answer is a page of a proxy
    };

    FakeTusServer();
    ~FakeTusServer();
    FakeTusServer(const FakeTusServer&) = delete;
    FakeTusServer& operator=(const FakeTusServer&) = delete;

    std::string url() const;
    void script_patches(std::deque<Fault> faults);
    void forget_upload();  // answers 404 until the upload is created again

    std::string stored();
    std::string last_metadata();
    std::int64_t body_bytes_received();
    int num_created();

private:
    void serve();
    void serve_connection(int socket);
    bool serve_request(int socket, std::string& pending);
    bool patch(int socket, const std::string& header, std::string& pending);

    FileDescriptor listener_;
    int port_ = 0;
    std::mutex mutex_;
    std::deque<Fault> faults_;
    std::string stored_;
    std::string metadata_;
    std::int64_t length_ = 0;
    std::int64_t body_bytes_ = 0;
    int num_created_ = 0;
    bool known_ = false;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace divemesh
