#include "api/router.hpp"

#include <gtest/gtest.h>

namespace divemesh::api {
namespace {

TEST(RouterTest, BindsAndUnescapesParameters) {
    const auto match = find_route(verb::get, "/api/v1/dives/dive%5F1");
    ASSERT_NE(match.route, nullptr);
    EXPECT_EQ(match.route->path, "/api/v1/dives/{dive_id}");
    EXPECT_EQ(match.parameters.at("dive_id"), "dive_1");
}

TEST(RouterTest, GivesAnArtifactItsSlashesEscapedOrNot) {
    for (const char* path : {"/api/v1/jobs/j/artifacts/keyframes/1.jpg",
                             "/api/v1/jobs/j/artifacts/keyframes%2F1.jpg"}) {
        const auto match = find_route(verb::get, path);
        ASSERT_NE(match.route, nullptr) << path;
        EXPECT_EQ(match.parameters.at("artifact_name"), "keyframes/1.jpg");
    }
}

TEST(RouterTest, TakesNoSlashNulOrEmptyTextAsAnId) {
    for (const char* path : {"/api/v1/dives/",
                             "/api/v1/dives/a%2Fb",
                             "/api/v1/dives/%00",
                             "/api/v1/dives/%zz",
                             "/api/v1/dives//findings",
                             "/api/v1/dives/a/",
                             "/api/v1/jobs/j/artifacts/",
                             "/api/v1",
                             "",
                             "//api/v1/dives"})
        EXPECT_EQ(find_route(verb::get, path).route, nullptr) << path;
}

TEST(RouterTest, ServesHeadByTheRouteOfGetAndNamesTheMethodsOtherwise) {
    EXPECT_EQ(find_route(verb::head, "/api/v1/dives").route,
              find_route(verb::get, "/api/v1/dives").route);
    EXPECT_EQ(find_route(verb::head, "/api/v1/uploads/u").route->method, verb::head);
    const auto match = find_route(verb::put, "/api/v1/dives");
    EXPECT_EQ(match.route, nullptr);
    EXPECT_EQ(match.methods, (std::vector{verb::get, verb::post}));
}

TEST(RouterTest, GuardsEveryRouteOfTheApiWithAScope) {
    ASSERT_FALSE(routes().empty());
    for (const Route& route : routes()) {
        const bool open = route.method == verb::options ||
                          (!route.path.starts_with("/api/") && route.path != "/metrics");
        EXPECT_EQ(route.scope.empty(), open) << route.path;
    }
}

}  // namespace
}  // namespace divemesh::api
