#include "api/uploads/tus_headers.hpp"

#include <cstdlib>

#include "api/byte_range.hpp"
#include "api/etag.hpp"
#include "api/target.hpp"
#include "api/uploads/upload_checksum.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "api/webhook_target.hpp"
#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using namespace divemesh;
using namespace divemesh::api;

constexpr std::int64_t kSize = 1000;

// What holds for every input; anything else is a bug.
void require(bool holds) {
    if (!holds) std::abort();
}

// Each reader of a header has its own chance: an Error of one does not keep the next from running.
template <typename Read>
void reading(const Read& read) {
    try {
        read();
    } catch (const Error&) {
        return;
    }
}

// The first line is the address, "name: value" in each of the others.
Request request_of(fuzz::Input input) {
    Request request;
    request.target = input.line();
    while (!input.empty()) {
        const auto line = input.line();
        const auto colon = line.find(": ");
        if (colon != std::string_view::npos)
            request.headers.emplace(line.substr(0, colon), line.substr(colon + 2));
    }
    return request;
}

void read_upload(const Request& request, const ServiceLimits& limits) {
    const Upload upload = announced_upload(request, limits);
    require(upload.is_final() || upload.length_bytes.value_or(0) <= limits.max_upload_bytes);
    if (!upload.is_final()) return;
    for (const std::string& part : parts_of(upload))
        require(!part.empty() && part.find('/') == std::string::npos);
}

void read_range(const Request& request) {
    const auto answer = parse_range(request.header("range"), kSize);
    if (!answer.range) return;
    const auto [offset, length] = *answer.range;
    require(offset >= 0 && length >= 1 && offset + length <= kSize);
}

void read_metadata(const Request& request) {
    const auto plan = plan_of(request.header("upload-metadata"));
    require(plan.name.find_first_of("/\\\r\n") == std::string::npos && plan.name.size() <= 200);
    const auto disposition = content_disposition("attachment", plan.name);
    require(disposition.find_first_of("\r\n") == std::string::npos);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const Request request = request_of(fuzz::Input(data, size));
    const ServiceLimits limits;
    reading([&] { wrong_version(request); });
    reading([&] { require(count_header(request, "upload-offset") >= 0); });
    reading([&] { brings_bytes(request); });
    reading([&] { read_upload(request, limits); });
    reading([&] { read_metadata(request); });
    reading([&] {
        UploadChecksum checksum(request.header("upload-checksum"));
        checksum.update({request.target.data(), request.target.size()});
        checksum.matches();
    });
    reading([&] { read_range(request); });
    reading([&] { matches_etag(request.header("if-none-match"), etag_of("body")); });
    reading([&] { require_match(request, "body"); });
    reading([&] { parse_target(request.target); });
    reading([&] { parse_webhook_url(request.target); });
    return 0;
}
