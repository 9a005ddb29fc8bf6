#include "storage/token_store.hpp"

#include <gmock/gmock.h>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

class TokenStoreTest : public StoreTest {
protected:
    TokenStore tokens_{catalog_};
};

TEST_F(TokenStoreTest, FindsATokenByItsSecretAndStoresOnlyTheHash) {
    EXPECT_TRUE(tokens_.empty());
    const CreatedToken created = tokens_.create(
        {.name = "laptop", .project = "north", .scopes = {"dives:write", "dives:read"}});

    EXPECT_THAT(created.secret, testing::MatchesRegex("dm_[0-9a-f]+"));
    EXPECT_EQ(created.secret.size(), 67u);
    EXPECT_FALSE(tokens_.empty());
    const auto found = tokens_.find(created.secret);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->id, created.token.id);
    EXPECT_EQ(found->project, "north");
    EXPECT_TRUE(found->allows("dives:write"));
    EXPECT_FALSE(found->allows("admin"));
    EXPECT_EQ(tokens_.list().at(0).secret_sha256, sha256_hex(created.secret));
    EXPECT_GT(tokens_.list().at(0).last_used_at_ms, 0);
}

TEST_F(TokenStoreTest, KnowsNoOtherSecret) {
    const std::string secret =
        tokens_.create({.name = "laptop", .project = "north", .scopes = {"admin"}}).secret;

    for (const std::string& wrong :
         {std::string(), secret.substr(1), secret + "0", std::string("' OR '1'='1")})
        EXPECT_FALSE(tokens_.find(wrong));
}

TEST_F(TokenStoreTest, LeavesOutAScopeThatDoesNotExist) {
    const std::string secret =
        tokens_.create({.name = "laptop", .project = "north", .scopes = {"dives:read"}}).secret;
    catalog_.transaction([](soci::session& session) {
        session << R"(UPDATE tokens SET scopes = '["dives:read","reports:write"]')";
    });

    EXPECT_EQ(tokens_.find(secret)->scopes, std::vector<std::string>{"dives:read"});
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] {
        tokens_.create({.name = "other", .project = "north", .scopes = {"reports:write"}});
    }));
}

TEST_F(TokenStoreTest, ARevokedTokenOpensNothing) {
    const CreatedToken created =
        tokens_.create({.name = "laptop", .project = "north", .scopes = {"admin"}});

    tokens_.revoke(created.token.id);

    EXPECT_FALSE(tokens_.find(created.secret));
    EXPECT_TRUE(tokens_.list().at(0).revoked);
    EXPECT_TRUE(tokens_.empty());
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { tokens_.revoke("token_x"); }));
}

TEST_F(TokenStoreTest, AnExpiredTokenOpensNothing) {
    const CreatedToken created =
        tokens_.create({.name = "day", .scopes = {"admin"}, .lifetime = std::chrono::hours(24)});
    EXPECT_TRUE(tokens_.is_valid(created.token.id));

    catalog_.transaction(
        [](soci::session& session) { session << "UPDATE tokens SET expires_at_ms = 1"; });

    EXPECT_FALSE(tokens_.find(created.secret));
    EXPECT_FALSE(tokens_.is_valid(created.token.id));
    EXPECT_TRUE(tokens_.empty());
}

TEST_F(TokenStoreTest, RefusesScopesItDoesNotKnow) {
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument,
                            [&] { tokens_.create({.name = "x", .project = "p", .scopes = {}}); }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] {
        tokens_.create({.name = "x", .project = "p", .scopes = {"root"}});
    }));
}

}  // namespace
}  // namespace divemesh::storage
