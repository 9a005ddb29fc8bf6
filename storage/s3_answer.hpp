#pragma once

#include <string>

#include "storage/http_exchange.hpp"
#include "storage/s3_location.hpp"

namespace divemesh::storage {

// What an object store says is wrong. The code is one of its words: "NoSuchKey".
struct S3Refusal {
    std::string code;
    std::string message;
    std::string region;  // where the bucket is, if it is elsewhere
};

// Reads the body of an answer; its parts are empty where it has none.
S3Refusal refusal_of(const HttpAnswer& answer);

// Returns whether a later try may succeed: no answer, an overloaded or broken server.
bool may_pass(const HttpAnswer& answer, const S3Refusal& refusal);

// Throws the Error that fits: what was done, what the store said, and what to do.
[[noreturn]] void throw_s3_error(const std::string& doing,
                                 const S3Location& location,
                                 const HttpAnswer& answer,
                                 const S3Refusal& refusal);

}  // namespace divemesh::storage
