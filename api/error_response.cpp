#include "api/error_response.hpp"

#include <nlohmann/json.hpp>

#include "api/rate_limiter.hpp"
#include "schemas/error.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/log.hpp"

namespace divemesh::api {
namespace {

http::status status_of(ErrorCode code) {
    switch (code) {  // no default: the compiler lists a code that is missing here
        case ErrorCode::InvalidArgument: return http::status::bad_request;
        case ErrorCode::BadData: return http::status::unprocessable_entity;
        case ErrorCode::NotFound: return http::status::not_found;
        case ErrorCode::Gone: return http::status::gone;
        case ErrorCode::Conflict: return http::status::conflict;
        case ErrorCode::Locked: return http::status::locked;
        case ErrorCode::PreconditionFailed: return http::status::precondition_failed;
        case ErrorCode::PreconditionRequired: return http::status::precondition_required;
        case ErrorCode::TooLarge: return http::status::payload_too_large;
        case ErrorCode::TooMany: return http::status::too_many_requests;
        case ErrorCode::Unauthorized: return http::status::unauthorized;
        case ErrorCode::Forbidden: return http::status::forbidden;
        case ErrorCode::Unsupported: return http::status::unsupported_media_type;
        case ErrorCode::Cancelled: return http::status::conflict;
        case ErrorCode::OutOfQuota: return http::status::forbidden;
        case ErrorCode::OutOfSpace: return http::status::insufficient_storage;
        case ErrorCode::OutOfMemory:
        case ErrorCode::Unavailable: return http::status::service_unavailable;
    }
    return http::status::internal_server_error;
}

// Returns the seconds of Retry-After; "" if a retry does not help.
std::string retry_after(ErrorCode code) {
    switch (code) {
        case ErrorCode::Locked:
        case ErrorCode::OutOfMemory:
        case ErrorCode::Unavailable: return "2";
        case ErrorCode::OutOfSpace:
        case ErrorCode::TooMany: return "60";
        default: return "";
    }
}

// Returns the faults in the form of the example of RFC 9457, 3.
nlohmann::json errors_of(const std::vector<Fault>& faults) {
    nlohmann::json errors = nlohmann::json::array();
    for (const Fault& fault : faults) {
        nlohmann::json error = {{"detail", fault.detail}};
        if (fault.parameter.empty())
            error["pointer"] = fault.pointer;
        else
            error["parameter"] = fault.parameter;
        errors.push_back(std::move(error));
    }
    return errors;
}

Response problem(const Request& request,
                 http::status status,
                 const std::string& type,
                 const std::string& detail,
                 const std::vector<Fault>& faults = {}) {
    nlohmann::json body = {{"type", type},
                           {"title", http::obsolete_reason(status)},
                           {"status", static_cast<int>(status)},
                           {"detail", detail},
                           {"instance", request.path},
                           {"request_id", request.id}};
    if (!faults.empty()) body["errors"] = errors_of(faults);
    Response response = json_response(status, body);
    response.headers = {{"Content-Type", "application/problem+json"},
                        {"Cache-Control", "no-store"}};
    return response;
}

// Adds the rate limit as structured fields (RFC 9651), by draft-ietf-httpapi-ratelimit-headers-10.
void advise(Response& response, const RateAdvice& advice) {
    const std::string wait = std::to_string(advice.wait_s);
    const std::string name = '"' + advice.policy + '"';
    response.set(
        "RateLimit-Policy",
        name + ";q=" + std::to_string(advice.quota) + ";w=" + std::to_string(advice.window_s));
    response.set("RateLimit", name + ";r=0;t=" + wait);
    response.set("Retry-After", wait);
}

}  // namespace

Response error_response(const Request& request, const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const Error& error) {
        const auto* input = dynamic_cast<const InvalidInput*>(&error);
        Response response = problem(request,
                                    status_of(error.code()),
                                    "urn:divemesh:error:" + std::string(to_string(error.code())),
                                    error.what(),
                                    input != nullptr ? input->faults() : std::vector<Fault>());
        if (error.code() == ErrorCode::Unauthorized) response.set("WWW-Authenticate", "Bearer");
        const std::string wait = retry_after(error.code());
        if (const auto* often = dynamic_cast<const TooOften*>(&error))
            advise(response, often->advice());
        else if (!wait.empty())
            response.set("Retry-After", wait);
        return response;
    } catch (const std::exception& error) {
        log_error({{"event", "internal_error"},
                   {"request_id", request.id},
                   {"path", request.path},
                   {"what", error.what()}});
    } catch (...) {
        log_error({{"event", "internal_error"}, {"request_id", request.id}});
    }
    return problem_response(request, http::status::internal_server_error, "internal error");
}

Response problem_response(const Request& request, http::status status, const std::string& detail) {
    return problem(request, status, "about:blank", detail);
}

}  // namespace divemesh::api
