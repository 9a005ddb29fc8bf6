#pragma once

#include <string>

namespace divemesh::pipeline {

// Returns the linker's build ids (NT_GNU_BUILD_ID) of this program and of the shared libraries that
// it has loaded, in hex, one after the other. They differ whenever the code differs, also between
// two builds of one version. An object that was linked without one is left out.
std::string build_id();

}  // namespace divemesh::pipeline
