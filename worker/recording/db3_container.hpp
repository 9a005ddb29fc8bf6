#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <unordered_map>

#include "worker/recording/container.hpp"
#include "worker/recording/db3_database.hpp"

namespace divemesh::recording {

inline constexpr std::string_view kSqliteMagic{"SQLite format 3\0", 16};

// A file of a ROS 2 bag in SQLite, as rosbag2_storage_sqlite3 writes it in every version of its
// schema (1 to 4), with messages that are compressed one by one or not. Its blocks are rows that
// follow each other.
class Db3Container final : public Container {
public:
    Db3Container(InputFile file,
                 dive::FindingLog& findings,
                 const base::ProgressCallback& progress);

    BlockContents read(const Block& block) const override;

private:
    // A row of the table of messages.
    struct Db3Row {
        std::int64_t number = 0;
        std::size_t topic = 0;
        std::int64_t log_time_ns = 0;
        std::string_view bytes;  // as they are stored
    };
    void learn_topics(dive::FindingLog& findings);
    void scan(dive::FindingLog& findings, const base::ProgressCallback& progress);
    // Passes the rows of a block on, and the number of a row from which some cannot be read.
    void for_each_row(const Block& block,
                      const std::function<void(const Db3Row&)>& on_row,
                      const std::function<void(std::int64_t)>& on_damage) const;
    std::int64_t last_row() const;

    Db3Database database_;
    std::unordered_map<std::int64_t, std::size_t> places_;  // in topics(), by the file's numbers
};

}  // namespace divemesh::recording
