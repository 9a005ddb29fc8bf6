#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace divemesh {

// The kinds of errors. api/error_response.cpp maps each code to one HTTP status, cli/exit_code.hpp
// to an exit code. An exception that is not an Error is a bug or a broken machine: "internal
// error".
enum class ErrorCode {
    InvalidArgument,  // the request or an option is wrong
    BadData,          // a recording is wrong; a retry cannot help
    NotFound,
    Gone,                  // it existed and does not come back
    Conflict,              // not in this state, or another caller was first
    Locked,                // another request holds it and did not release it in time
    PreconditionFailed,    // If-Match: it has changed since it was read
    PreconditionRequired,  // without If-Match it is unclear which version would be changed
    TooLarge,
    TooMany,       // too many at once, or too often: wait
    Unauthorized,  // no token, or an unknown one
    Forbidden,     // the token's scope or project does not allow it
    Unsupported,   // an unsupported media type, protocol version or format
    Cancelled,
    OutOfQuota,   // the project's quota is used up: delete something, or ask for more
    OutOfSpace,   // the disk is full
    OutOfMemory,  // of the machine, or the limit of a process
    Unavailable,  // retry later: network, database, a locked file
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
