#include "tests/bench/kept_results.hpp"

#include <array>
#include <fstream>
#include <stdexcept>

#include "schemas/content_hash.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string file_sha256(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw std::runtime_error("cannot read " + file.string());
    Sha256 hash;
    std::array<char, 65536> bytes{};
    while (stream.read(bytes.data(), bytes.size()) || stream.gcount() > 0)
        hash.update({bytes.data(), static_cast<std::size_t>(stream.gcount())});
    return hash.hex();
}

}  // namespace

KeptResults::KeptResults(fs::path folder, const fs::path& program)
    : folder_(std::move(folder)), program_sha256_(file_sha256(program)) {}

std::optional<json> KeptResults::find(const std::string& run) const {
    std::ifstream stream(file_of(run));
    if (!stream) return std::nullopt;
    const json kept = json::parse(stream, nullptr, false);
    if (kept.is_discarded() || kept.value("program_sha256", "") != program_sha256_)
        return std::nullopt;
    return kept.at("result");
}

void KeptResults::keep(const std::string& run, const json& result) const {
    const fs::path unfinished = file_of(run).string() + ".part";
    std::ofstream stream(unfinished);
    stream << json{{"program_sha256", program_sha256_}, {"result", result}}.dump(2) << "\n";
    stream.close();
    if (!stream) throw std::runtime_error("cannot write " + unfinished.string());
    fs::rename(unfinished, file_of(run));
}

fs::path KeptResults::file_of(const std::string& run) const { return folder_ / (run + ".json"); }

}  // namespace divemesh::bench
