#include "worker/recording/provenance.hpp"

#include <utility>

#include "schemas/content_hash.hpp"
#include "worker/recording/input_file.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kHashed_bytes = std::int64_t{1} << 20U;  // at a time

}  // namespace

ImportedFile imported_file(std::string name, const std::vector<std::filesystem::path>& files) {
    Sha256 hash;
    ImportedFile imported{.name = std::move(name), .sha256 = "", .size_bytes = 0};
    for (const std::filesystem::path& part : files) {
        const InputFile file(part);
        imported.size_bytes += file.size_bytes();
        for (std::int64_t at = 0; at < file.size_bytes(); at += kHashed_bytes)
            hash.update(file.read(at, kHashed_bytes));
    }
    imported.sha256 = hash.hex();
    return imported;
}

void remove_names(Provenance& provenance) {
    provenance.name.clear();
    for (ImportedFile& file : provenance.files) {
        for (Finding& finding : provenance.findings)
            if (finding.where.starts_with(file.name))
                finding.where.replace(0, file.name.size(), "recording");
        file.name.clear();
    }
}

}  // namespace divemesh::recording
