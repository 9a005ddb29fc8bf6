// Job states are written in C++ and in SQL; this test compares the two.
#include <gtest/gtest.h>

#include <soci/soci.h>
#include <string>

#include "schemas/job_state.hpp"
#include "storage/catalog.hpp"
#include "tests/storage/place.hpp"

namespace divemesh::storage {
namespace {

class JobStatesTest : public testing::Test {
protected:
    JobStatesTest() {
        EXPECT_TRUE(
            accepts("INSERT INTO dives (id, project, name, archive_sha256, archive_bytes, blob,"
                    " created_at_ms) VALUES ('dive', 'p', 'n', '', 0, 'b', 0)"));
    }

    static std::string quoted(std::string_view word) {
        std::string text(1, '\'');
        text.append(word).append(1, '\'');
        return text;
    }
    static std::string lease(std::string_view state) {
        return state == "running" ? "'lease', 1" : "NULL, NULL";
    }
    bool insert(std::string_view state) {
        return accepts(
            "INSERT INTO jobs (id, project, dive_id, kind, state, lease_id, lease_expires_at_ms,"
            " max_attempts, progress, created_at_ms) VALUES ('job', 'p', 'dive', 'reconstruct', " +
            quoted(state) + ", " + lease(state) + ", 3, '{}', 0)");
    }
    bool update(std::string_view state) {
        return accepts("UPDATE jobs SET (state, lease_id, lease_expires_at_ms) = (" +
                       quoted(state) + ", " + lease(state) + ")");
    }
    bool accepts(const std::string& sql) {
        try {
            catalog_.transaction([&](soci::session& session) { session << sql; });
            return true;
        } catch (const soci::soci_error&) {
            return false;
        }
    }

    Place place_;
    Catalog catalog_{place_.url()};
};

TEST_F(JobStatesTest, TheDatabaseAllowsExactlyTheDeclaredTransitions) {
    for (const JobState from : kJobStates)
        for (const JobState to : kJobStates) {
            accepts("DELETE FROM jobs");
            ASSERT_TRUE(insert(to_string(from))) << to_string(from);
            EXPECT_EQ(update(to_string(to)), can_transition(from, to))
                << to_string(from) << " -> " << to_string(to);
        }
}

TEST_F(JobStatesTest, TheDatabaseKnowsNoOtherState) {
    EXPECT_FALSE(insert("leased"));
    EXPECT_FALSE(insert(""));
}

TEST_F(JobStatesTest, OnlyARunningJobHasALease) {
    ASSERT_TRUE(insert("queued"));
    EXPECT_FALSE(accepts("UPDATE jobs SET state = 'running'"));
    EXPECT_FALSE(accepts("UPDATE jobs SET lease_id = 'lease', lease_expires_at_ms = 1"));
}

}  // namespace
}  // namespace divemesh::storage
