#pragma once

#include <string>

namespace divemesh::pipeline {

// What the linker marked this program with (NT_GNU_BUILD_ID), in hex: differs whenever its code
// does, also between two builds of one version. "" when it was linked without.
std::string build_id();

}  // namespace divemesh::pipeline
