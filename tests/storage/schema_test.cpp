// The schemas of the engines are written twice; these tests compare them.
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "storage/catalog.hpp"
#include "tests/storage/place.hpp"

namespace divemesh::storage {
namespace {

// What one engine says of its schema, a line for each thing.
using Lines = std::set<std::string>;

std::string replaced(const std::string& text, const char* expression, const char* by) {
    return std::regex_replace(text, std::regex(expression), by);
}

// Writes a condition or a default as both engines would: in one case, without brackets and casts.
std::string plain(const std::string& sql) {
    std::string text = replaced(sql, "::[a-z]+", "");
    text = replaced(text, "'(-?[0-9]+)'", "$1");
    text = replaced(text, R"((\w+) BETWEEN (\w+) AND (\w+))", "$1 >= $2 AND $1 <= $3");
    text = replaced(text, R"(= ANY \(ARRAY)", "IN (");
    text = replaced(text, R"(<> ALL \(ARRAY)", "NOT IN (");
    text = replaced(text, R"x([\[\]()"])x", " ");
    text = replaced(text, R"(\s+)", " ");
    return replaced(text, " ?(,) ?|^ | $", "$1");
}

// Returns the conditions after this word in a CREATE statement, up to the bracket that closes each.
std::vector<std::string> conditions_after(const std::string& word, const std::string& sql) {
    std::vector<std::string> found;
    for (auto at = sql.find(word + " ("); at != std::string::npos; at = sql.find(word + " (", at)) {
        at += word.size() + 1;
        int depth = 0;
        auto end = at;
        do {
            if (sql[end] == '(') ++depth;
            if (sql[end] == ')') --depth;
            ++end;
        } while (depth > 0 && end < sql.size());
        found.push_back(sql.substr(at, end - at));
        at = end;
    }
    return found;
}

class PostgresqlSchemaTest : public testing::Test {
protected:
    void SetUp() override {
        if (!PostgresqlServer::is_installed()) GTEST_SKIP() << "PostgreSQL is not installed";
        if (!postgresql_server().has_database("schema_test"))
            postgresql_server().run("CREATE DATABASE schema_test");
        postgresql_ = std::make_unique<Catalog>(postgresql_server().url("schema_test"));
    }

    using Rows = std::vector<std::pair<std::string, std::string>>;
    static Rows rows(Catalog& catalog, const std::string& sql) {
        Rows found;
        catalog.read([&](soci::session& session) {
            std::string what;
            std::string more;
            soci::statement statement =
                (session.prepare << sql, soci::into(what), soci::into(more));
            statement.execute(false);
            while (statement.fetch()) found.emplace_back(what, more);
        });
        return found;
    }
    // Returns a line for each row: the first column as it is, then the second, made plain.
    static Lines lines(Catalog& catalog, const std::string& sql) {
        Lines all;
        for (const auto& [what, more] : rows(catalog, sql)) all.insert(what + ": " + plain(more));
        return all;
    }
    Lines of_sqlite(const std::string& sql) { return lines(sqlite_, sql); }
    Lines of_postgresql(const std::string& sql) { return lines(*postgresql_, sql); }

    TemporaryFolder folder_;
    Catalog sqlite_{"sqlite://" + (folder_ / "catalog.db").string()};
    std::unique_ptr<Catalog> postgresql_;
};

std::string of_each_sqlite_table(const std::string& columns, const std::string& rows) {
    return "SELECT " + columns + " FROM sqlite_master AS t, " + rows +
           " WHERE t.type = 'table' AND t.name NOT LIKE 'sqlite%'";
}

TEST_F(PostgresqlSchemaTest, HasTheVersionOfTheOneInSqlite) {
    EXPECT_EQ(postgresql_->schema_version(), sqlite_.schema_version());
}

TEST_F(PostgresqlSchemaTest, HasTheSameColumns) {
    const Lines columns = of_sqlite(of_each_sqlite_table(
        "t.name || '.' || c.name || ' ' || c.type ||"
        " CASE WHEN c.\"notnull\" OR c.pk THEN ' NOT NULL' ELSE '' END, COALESCE(c.dflt_value, '')",
        "pragma_table_info(t.name) AS c"));
    EXPECT_GT(columns.size(), 200U);
    EXPECT_EQ(
        of_postgresql(
            "SELECT table_name || '.' || column_name || ' ' || CASE data_type"
            " WHEN 'bigint' THEN 'INTEGER' WHEN 'integer' THEN 'INTEGER' WHEN 'bytea' THEN 'BLOB'"
            " WHEN 'double precision' THEN 'REAL' WHEN 'text' THEN 'TEXT' ELSE data_type END ||"
            " CASE is_nullable WHEN 'NO' THEN ' NOT NULL' ELSE '' END, COALESCE(column_default, '')"
            " FROM information_schema.columns WHERE table_schema = 'public'"),
        columns);
}

TEST_F(PostgresqlSchemaTest, SortsEveryTextByItsBytes) {
    EXPECT_EQ(of_postgresql("SELECT table_name || '.' || column_name, ''"
                            " FROM information_schema.columns WHERE table_schema = 'public'"
                            " AND data_type = 'text' AND collation_name IS DISTINCT FROM 'C'"),
              Lines());
}

TEST_F(PostgresqlSchemaTest, HasTheSameKeys) {
    const Lines keys = of_sqlite(
        of_each_sqlite_table("t.name || ' primary ', (SELECT group_concat(name) FROM (SELECT name"
                             " FROM pragma_table_info(t.name) WHERE pk > 0 ORDER BY pk))",
                             "(SELECT 1)") +
        " AND EXISTS (SELECT 1 FROM pragma_table_info(t.name) WHERE pk > 0) UNION ALL " +
        of_each_sqlite_table("t.name || ' unique ',"
                             " (SELECT group_concat(name) FROM pragma_index_info(i.name))",
                             "pragma_index_list(t.name) AS i") +
        " AND i.origin = 'u'");
    EXPECT_GT(keys.size(), 35U);
    EXPECT_EQ(of_postgresql(
                  "SELECT conrelid::regclass::text || CASE contype WHEN 'p' THEN ' primary ' ELSE"
                  " ' unique ' END, (SELECT string_agg(attname, ',' ORDER BY place) FROM"
                  " unnest(conkey) WITH ORDINALITY AS k (number, place)"
                  " JOIN pg_attribute ON attrelid = conrelid AND attnum = number)"
                  " FROM pg_constraint WHERE contype IN ('p', 'u')"
                  " AND connamespace = 'public'::regnamespace"),
              keys);
}

TEST_F(PostgresqlSchemaTest, HasTheSameReferences) {
    const Lines references = of_sqlite(of_each_sqlite_table(
        "t.name || '.' || f.\"from\" || ' to ' || f.\"table\" || '.' || f.\"to\", f.on_delete",
        "pragma_foreign_key_list(t.name) AS f"));
    EXPECT_GT(references.size(), 15U);
    EXPECT_EQ(of_postgresql(
                  "SELECT conrelid::regclass::text || '.' || own.attname || ' to ' ||"
                  " confrelid::regclass::text || '.' || other.attname,"
                  " CASE confdeltype WHEN 'c' THEN 'CASCADE' ELSE 'NO ACTION' END"
                  " FROM pg_constraint"
                  " JOIN pg_attribute AS own ON own.attrelid = conrelid AND own.attnum = conkey[1]"
                  " JOIN pg_attribute AS other ON other.attrelid = confrelid"
                  "  AND other.attnum = confkey[1]"
                  " WHERE contype = 'f'"),
              references);
}

TEST_F(PostgresqlSchemaTest, HasTheSameIndexes) {
    Lines indexes;
    for (const auto& [index, sql] :
         rows(sqlite_,
              of_each_sqlite_table(
                  "t.name || ' ' || i.name || CASE WHEN i.\"unique\" THEN ' unique' ELSE '' END ||"
                  " ' ' || (SELECT group_concat(name) FROM pragma_index_info(i.name)),"
                  " (SELECT sql FROM sqlite_master WHERE name = i.name)",
                  "pragma_index_list(t.name) AS i") +
                  " AND i.origin = 'c'")) {
        const auto condition = sql.find("WHERE ");
        indexes.insert(index + ": " +
                       (condition == std::string::npos ? "" : plain(sql.substr(condition + 6))));
    }
    EXPECT_GT(indexes.size(), 40U);
    EXPECT_EQ(
        of_postgresql("SELECT indrelid::regclass::text || ' ' || relname ||"
                      " CASE WHEN indisunique THEN ' unique' ELSE '' END || ' ' ||"
                      " (SELECT string_agg(attname, ',' ORDER BY place) FROM"
                      "  unnest(indkey) WITH ORDINALITY AS k (number, place)"
                      "  JOIN pg_attribute ON attrelid = indrelid AND attnum = number),"
                      " COALESCE(pg_get_expr(indpred, indrelid), '')"
                      " FROM pg_index JOIN pg_class ON pg_class.oid = indexrelid"
                      " WHERE relnamespace = 'public'::regnamespace"
                      " AND NOT EXISTS (SELECT 1 FROM pg_constraint WHERE conindid = indexrelid"
                      "  AND contype IN ('p', 'u'))"),
        indexes);
}

TEST_F(PostgresqlSchemaTest, HasTheSameChecks) {
    Lines checks;
    for (const auto& [table, sql] :
         rows(sqlite_, of_each_sqlite_table("t.name, t.sql", "(SELECT 1)")))
        for (const std::string& condition : conditions_after("CHECK", sql))
            checks.insert(table + ": " + plain(condition));
    EXPECT_GT(checks.size(), 35U);
    EXPECT_EQ(of_postgresql("SELECT conrelid::regclass::text, pg_get_expr(conbin, conrelid)"
                            " FROM pg_constraint WHERE contype = 'c'"
                            " AND connamespace = 'public'::regnamespace"),
              checks);
}

TEST_F(PostgresqlSchemaTest, HasTheSameTriggers) {
    const Lines triggers =
        of_sqlite("SELECT tbl_name, name FROM sqlite_master WHERE type = 'trigger'");
    EXPECT_GT(triggers.size(), 8U);
    EXPECT_EQ(of_postgresql("SELECT tgrelid::regclass::text, tgname FROM pg_trigger"
                            " WHERE NOT tgisinternal AND tgname <> 'jobs_wake_workers'"),
              triggers);
}

}  // namespace
}  // namespace divemesh::storage
