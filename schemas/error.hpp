#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace divemesh {

// What went wrong, in the words of the domain. api/error_response.cpp maps each code to one HTTP
// status, cli/exit_code.hpp to an exit code. Anything that is not an Error is a bug or a broken
// machine: "internal error".
enum class ErrorCode {
    InvalidArgument,  // the request or an option is wrong
    BadData,          // a recording is wrong; trying again cannot help
    NotFound,
    Gone,                  // it was here and does not come back
    Conflict,              // not in this state, or somebody else was first
    Locked,                // another request holds it and has not let go in time
    PreconditionFailed,    // If-Match: it has changed since it was read
    PreconditionRequired,  // without If-Match nobody knows what would be changed
    TooLarge,
    TooMany,       // too many at once, or too often: wait
    Unauthorized,  // no token, or an unknown one
    Forbidden,     // the token's scope or project does not allow it
    Unsupported,   // a media type, protocol version or format we do not speak
    Cancelled,
    OutOfQuota,   // the project has as much as it may have: make room, or ask for more
    OutOfSpace,   // the disk is full
    OutOfMemory,  // of the machine, or of what a process may have
    Unavailable,  // try again later: network, database, a locked file
};

// The message says what was wrong, where (file, line, frame) and what to do.
class Error : public std::runtime_error {
public:
    Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}

    ErrorCode code() const { return code_; }

private:
    ErrorCode code_;
};

std::string_view to_string(ErrorCode code);
ErrorCode error_code_from_string(std::string_view text);  // throws Error{InvalidArgument}

}  // namespace divemesh
