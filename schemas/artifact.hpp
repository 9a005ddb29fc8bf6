#pragma once

#include <cstdint>
#include <string>

namespace divemesh {

// A named, hashed, immutable output file of an attempt.
struct Artifact {
    std::string job_id;
    std::string name;        // mesh.glb, keyframes/000012.jpg
    std::string media_type;  // model/gltf-binary
    std::string sha256;
    std::int64_t size_bytes = 0;
    std::string blob;  // key in the blob store; not shown over HTTP
};

// By the extension; application/octet-stream for what we do not know.
std::string media_type_of(const std::string& name);

}  // namespace divemesh
