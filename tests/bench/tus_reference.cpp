#include "tests/bench/tus_reference.hpp"

#include <iostream>
#include <string>

#include "tests/paths.hpp"

namespace divemesh::bench {

using namespace std::chrono_literals;

std::optional<TusReferenceServer> TusReferenceServer::start(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder / "uploads");
    Process process({"/usr/bin/env",
                     "node",
                     (source_directory() / "tests/bench/tus_reference_server.mjs").string(),
                     (folder / "uploads").string()},
                    folder);
    const std::string mark = "port ";
    const auto said = [&] {
        const std::string text = process.stdout_text();
        return text.starts_with(mark) && text.ends_with('\n');
    };
    wait_until(20s, [&] { return said() || process.wait(0s).has_value(); });
    if (!said()) {
        std::cerr << "no @tus/server to compare with: " << process.stderr_text() << std::endl;
        return std::nullopt;
    }
    const int port = std::stoi(process.stdout_text().substr(mark.size()));
    return TusReferenceServer(std::move(process), port);
}

}  // namespace divemesh::bench
