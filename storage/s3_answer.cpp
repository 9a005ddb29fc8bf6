#include "storage/s3_answer.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "schemas/error.hpp"
#include "storage/xml_tree.hpp"

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxMessageBytes = 300;

// What to do about the refusals that come from how the store was set up.
struct Advice {
    std::string_view code;
    ErrorCode error;
    std::string_view text;
};
constexpr std::array kAdvice = {
    Advice{"NoSuchBucket",
           ErrorCode::Unavailable,
           "there is no such bucket: create it, or correct --blobs"},
    Advice{"InvalidAccessKeyId",
           ErrorCode::Unavailable,
           "the store does not know the access key: correct AWS_ACCESS_KEY_ID"},
    Advice{"SignatureDoesNotMatch",
           ErrorCode::Unavailable,
           "the secret key does not belong to the access key: correct AWS_SECRET_ACCESS_KEY"},
    Advice{"ExpiredToken",
           ErrorCode::Unavailable,
           "the session token has expired: set a new AWS_SESSION_TOKEN and restart"},
    Advice{"RequestTimeTooSkewed",
           ErrorCode::Unavailable,
           "the clocks of this machine and of the store differ: set this machine's clock (NTP)"},
    Advice{"AccessDenied",
           ErrorCode::Unavailable,
           "the key may not do this: allow it s3:ListBucket, s3:GetObject, s3:PutObject, "
           "s3:DeleteObject, s3:AbortMultipartUpload and s3:ListBucketMultipartUploads on the "
           "bucket"},
    Advice{"QuotaExceeded", ErrorCode::OutOfSpace, "the store's quota is used up: raise it"},
    Advice{"EntityTooLarge", ErrorCode::TooLarge, "the store takes no object of this size"},
};

std::string printable(std::string_view text) {
    std::string result(text.substr(0, kMaxMessageBytes));
    std::replace_if(
        result.begin(), result.end(), [](char c) { return c < ' ' || c == 127; }, ' ');
    return result;
}

const Advice* advice_for(const std::string& code) {
    const auto* found = std::find_if(
        kAdvice.begin(), kAdvice.end(), [&](const Advice& advice) { return advice.code == code; });
    return found == kAdvice.end() ? nullptr : found;
}

}  // namespace

S3Refusal refusal_of(const HttpAnswer& answer) {
    if (answer.body.empty() || answer.is_cut_off) return {};
    try {
        const XmlNode root = parse_xml(answer.body);
        if (root.name != "Error") return {};
        const auto bucket_region = answer.headers.find("x-amz-bucket-region");
        const bool is_moved = answer.status == 301 && bucket_region != answer.headers.end();
        return {printable(root.text_of("Code")),
                printable(root.text_of("Message")),
                printable(is_moved ? bucket_region->second : root.text_of("Region"))};
    } catch (const Error&) {
        return {};  // a proxy has answered
    }
}

bool may_pass(const HttpAnswer& answer, const S3Refusal& refusal) {
    constexpr std::array<long, 6> kPassing = {408, 429, 500, 502, 503, 504};
    if (answer.status == 0) return answer.failure_may_pass;
    return std::find(kPassing.begin(), kPassing.end(), answer.status) != kPassing.end() ||
           refusal.code == "RequestTimeout" || refusal.code == "InternalError" ||
           refusal.code == "SlowDown";
}

void throw_s3_error(const std::string& doing,
                    const S3Location& location,
                    const HttpAnswer& answer,
                    const S3Refusal& refusal) {
    const std::string where = doing + " in " + location.text() + ": ";
    if (answer.status == 0)
        throw Error(ErrorCode::Unavailable,
                    where + answer.failure +
                        ": try again, or check the address of the object store and the network");
    const std::string said = "status " + std::to_string(answer.status) +
                             (refusal.code.empty() ? "" : " " + refusal.code) +
                             (refusal.message.empty() ? "" : " (" + refusal.message + ")");
    if (!refusal.region.empty())
        throw Error(ErrorCode::Unavailable,
                    where + said + ": the bucket is in another region: add region=" +
                        refusal.region + " to --blobs");
    if (const Advice* advice = advice_for(refusal.code))
        throw Error(advice->error, where + said + ": " + std::string(advice->text));
    const auto code = answer.status == 404 ? ErrorCode::NotFound : ErrorCode::Unavailable;
    throw Error(code, where + said + ": see the log of the object store");
}

}  // namespace divemesh::storage
