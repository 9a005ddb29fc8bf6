#pragma once

#include <string>

#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"

namespace divemesh {

// Creates a dive in state ready, without upload and worker, and returns its id.
std::string make_ready_dive(storage::Catalog& catalog,
                            const std::string& project,
                            const std::string& archive_sha256,
                            const storage::IntakeResult& intake = {});

}  // namespace divemesh
