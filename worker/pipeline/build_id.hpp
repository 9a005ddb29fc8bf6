#pragma once

#include <string>

namespace divemesh::pipeline {

// Returns the linker's build id of this program (NT_GNU_BUILD_ID) in hex. It differs whenever the
// code differs, also between two builds of one version. "" if the program was linked without one.
std::string build_id();

}  // namespace divemesh::pipeline
