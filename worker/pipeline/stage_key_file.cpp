#include "worker/pipeline/stage_key_file.hpp"

#include "worker/base/binary_file.hpp"

namespace divemesh::pipeline {

void save_stage_key(const std::filesystem::path& path, const std::string& key) {
    base::BinaryWriter file(path);
    file.put_text(key);
    file.commit();
}

bool has_stage_key(const std::filesystem::path& path, const std::string& key) {
    base::BinaryReader file(path);
    return file.ok() && file.get_text() == key && file.at_end();
}

}  // namespace divemesh::pipeline
