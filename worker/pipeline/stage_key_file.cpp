#include "worker/pipeline/stage_key_file.hpp"

#include "worker/base/binary_file.hpp"

namespace divemesh::worker {

void save_stage_key(const std::filesystem::path& path, const std::string& key) {
    BinaryWriter file(path);
    file.put_text(key);
    file.commit();
}

bool has_stage_key(const std::filesystem::path& path, const std::string& key) {
    BinaryReader file(path);
    return file.ok() && file.get_text() == key && file.at_end();
}

}  // namespace divemesh::worker
