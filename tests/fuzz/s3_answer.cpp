#include "storage/s3_answer.hpp"

#include <algorithm>
#include <cstdlib>

#include "schemas/error.hpp"
#include "storage/xml_tree.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using namespace divemesh;
using namespace divemesh::storage;

// What holds for every input; anything else is a bug.
void require(bool holds) {
    if (!holds) std::abort();
}

bool is_one_line(const std::string& text) {
    return std::none_of(text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; });
}

void read_address(const std::string& url) {
    const S3Location location = parse_s3_url(url);
    require(is_one_line(location.host()) && is_one_line(location.path("dives/x")));
    require(location.scheme() == "http" || location.scheme() == "https");
}

void read_answer(const std::string& body) {
    const HttpAnswer answer{.status = 403, .body = body};
    const S3Refusal refusal = refusal_of(answer);
    require(is_one_line(refusal.code) && is_one_line(refusal.message));
    require(refusal.message.size() <= 300);
    parse_xml(body);
}

template <typename Read>
void reading(const Read& read) {
    try {
        read();
    } catch (const Error&) {
        return;
    }
}

}  // namespace

// The first line is an address, the rest an answer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input(data, size);
    const std::string url(input.line());
    const std::string body(input.rest());
    reading([&] { read_address(url); });
    reading([&] { read_answer(body); });
    return 0;
}
