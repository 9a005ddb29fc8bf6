#include "api/error_response.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

Response response_to(const std::exception_ptr& failure) {
    Request request;
    request.path = "/api/v1/dives";
    request.id = "r1";
    return error_response(request, failure);
}

nlohmann::json body_of(const Response& response) {
    return nlohmann::json::parse(std::get<std::string>(response.body));
}

TEST(ErrorResponseTest, MapsEveryCodeToItsStatus) {
    const std::pair<ErrorCode, int> expected[] = {{ErrorCode::InvalidArgument, 400},
                                                  {ErrorCode::BadData, 422},
                                                  {ErrorCode::NotFound, 404},
                                                  {ErrorCode::Conflict, 409},
                                                  {ErrorCode::PreconditionFailed, 412},
                                                  {ErrorCode::PreconditionRequired, 428},
                                                  {ErrorCode::TooLarge, 413},
                                                  {ErrorCode::TooMany, 429},
                                                  {ErrorCode::Unauthorized, 401},
                                                  {ErrorCode::Forbidden, 403},
                                                  {ErrorCode::Unsupported, 415},
                                                  {ErrorCode::Cancelled, 409},
                                                  {ErrorCode::OutOfQuota, 403},
                                                  {ErrorCode::OutOfSpace, 507},
                                                  {ErrorCode::OutOfMemory, 503},
                                                  {ErrorCode::Unavailable, 503}};
    for (const auto& [code, status] : expected) {
        const auto response = response_to(std::make_exception_ptr(Error(code, "why")));
        EXPECT_EQ(static_cast<int>(response.status), status);
        const auto body = body_of(response);
        EXPECT_EQ(body["status"], status);
        EXPECT_EQ(body["detail"], "why");
        EXPECT_EQ(body["type"], "urn:divemesh:error:" + std::string(to_string(code)));
        EXPECT_EQ(body["request_id"], "r1");
    }
}

TEST(ErrorResponseTest, SaysWhenToComeBackWhereThatHelps) {
    const auto wait_of = [](ErrorCode code) {
        const auto response = response_to(std::make_exception_ptr(Error(code, "why")));
        std::string wait;
        for (const auto& [name, value] : response.headers)
            if (name == "Retry-After") wait = value;
        return wait;
    };
    for (const auto code : {ErrorCode::Locked, ErrorCode::OutOfMemory, ErrorCode::Unavailable})
        EXPECT_EQ(wait_of(code), "2");
    for (const auto code : {ErrorCode::OutOfSpace, ErrorCode::TooMany})
        EXPECT_EQ(wait_of(code), "60");
    for (const auto code : {ErrorCode::BadData, ErrorCode::OutOfQuota, ErrorCode::Conflict})
        EXPECT_EQ(wait_of(code), "");
}

TEST(ErrorResponseTest, ShowsNothingOfAnErrorThatIsNotOurs) {
    const auto response =
        response_to(std::make_exception_ptr(std::runtime_error("/secret/catalog.db: SELECT")));
    EXPECT_EQ(static_cast<int>(response.status), 500);
    EXPECT_EQ(body_of(response)["detail"], "internal error");
    EXPECT_EQ(std::get<std::string>(response.body).find("secret"), std::string::npos);
}

TEST(ErrorResponseTest, ShowsHostileBytesAsJson) {
    const auto response = response_to(
        std::make_exception_ptr(Error(ErrorCode::NotFound, "no dive \xff\"\r\n<script>")));
    EXPECT_NE(body_of(response)["detail"].get<std::string>().find("no dive"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::api
