#pragma once

#include <filesystem>
#include <system_error>

#include "schemas/error.hpp"

namespace divemesh::runner {

// A failure of the worker's own storage, in which the job has no part.
class StorageError : public Error {
public:
    using Error::Error;
};

// Runs work of the parent on scratch and blobs. Turns what it throws into StorageError, unless the
// data themselves are the reason.
template <typename Work>
auto on_own_storage(const Work& work) {
    try {
        return work();
    } catch (const Error& error) {
        if (error.code() != ErrorCode::Unavailable && error.code() != ErrorCode::OutOfSpace) throw;
        throw StorageError(error.code(), error.what());
    } catch (const std::filesystem::filesystem_error& error) {
        const bool full = error.code() == std::errc::no_space_on_device;
        throw StorageError(full ? ErrorCode::OutOfSpace : ErrorCode::Unavailable, error.what());
    }
}

}  // namespace divemesh::runner
