#pragma once

#include <filesystem>
#include <optional>

#include "tests/end_to_end/process.hpp"

namespace divemesh::bench {

// A process of the reference implementation of tus, @tus/server of npm, that stores in a folder.
class TusReferenceServer {
public:
    // Returns nullopt if its packages are missing (npm ci in tests/end_to_end/js) or do not run.
    static std::optional<TusReferenceServer> start(const std::filesystem::path& folder);

    int port() const { return port_; }

private:
    TusReferenceServer(Process process, int port) : process_(std::move(process)), port_(port) {}

    Process process_;
    int port_;
};

}  // namespace divemesh::bench
