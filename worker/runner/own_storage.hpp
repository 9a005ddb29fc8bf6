#pragma once

#include <filesystem>
#include <system_error>

#include "schemas/error.hpp"

namespace divemesh::runner {

// Runs work of the parent on scratch and blobs. Throws what it throws, failures of the file system
// as Error{OutOfSpace} or Error{Unavailable}.
template <typename Work>
auto on_own_storage(const Work& work) {
    try {
        return work();
    } catch (const std::filesystem::filesystem_error& error) {
        const bool full = error.code() == std::errc::no_space_on_device;
        throw Error(full ? ErrorCode::OutOfSpace : ErrorCode::Unavailable, error.what());
    }
}

}  // namespace divemesh::runner
