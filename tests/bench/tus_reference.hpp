#pragma once

#include <filesystem>
#include <optional>

#include "tests/end_to_end/process.hpp"

namespace divemesh::bench {

// The reference implementation of tus, @tus/server of npm, as a process over a folder.
class TusReferenceServer {
public:
    // Nothing when its packages are not there (npm ci in tests/end_to_end/js) or do not run.
    static std::optional<TusReferenceServer> start(const std::filesystem::path& folder);

    int port() const { return port_; }

private:
    TusReferenceServer(Process process, int port) : process_(std::move(process)), port_(port) {}

    Process process_;
    int port_;
};

}  // namespace divemesh::bench
