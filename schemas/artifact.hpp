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

// Returns the media type for a file's extension; application/octet-stream if it is unknown.
std::string media_type_of(const std::string& name);

}  // namespace divemesh
