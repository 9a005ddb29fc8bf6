#include "worker/recording/provenance.hpp"

#include "schemas/content_hash.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kHashed_bytes = std::int64_t{1} << 20U;  // at a time

}  // namespace

Provenance provenance_of(const InputFile& file) {
    Sha256 hash;
    for (std::int64_t at = 0; at < file.size_bytes(); at += kHashed_bytes)
        hash.update(file.read(at, kHashed_bytes));
    return {file.path().filename().string(), hash.hex(), file.size_bytes()};
}

}  // namespace divemesh::recording
