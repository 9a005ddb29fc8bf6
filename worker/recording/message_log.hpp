#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "worker/recording/container.hpp"

namespace divemesh::recording {

// A message as it was recorded.
struct LoggedMessage {
    std::size_t topic = 0;         // its place in MessageLog::topics()
    std::int64_t log_time_ns = 0;  // when it was recorded, not when it was measured
    std::string_view bytes;
};

// The messages of a recording, whatever its format, in the order of their log times. Only the
// blocks that overlap in time are in memory, up to 1 GiB; the order is that of the file beyond.
class MessageLog {
public:
    // Opens a recording as open_container() does.
    MessageLog(const std::filesystem::path& path,
               dive::FindingLog& findings,
               const base::ProgressCallback& progress = base::ignore_progress);

    const std::vector<Topic>& topics() const { return container_->topics(); }
    std::int64_t num_messages() const { return num_messages_; }
    // Returns the next message, whose bytes live until the next call; nullopt at the end.
    std::optional<LoggedMessage> next();
    void rewind();

private:
    struct OpenBlock {
        BlockContents contents;
        std::size_t place = 0;         // in `order_`
        std::size_t next_message = 0;  // in contents.messages, which are in the order of time

        std::int64_t time_ns() const { return contents.messages[next_message].log_time_ns; }
    };
    static bool is_later(const std::unique_ptr<OpenBlock>& a, const std::unique_ptr<OpenBlock>& b);
    bool must_open_a_block() const;
    void open_next_block();
    void put_back_current();

    std::unique_ptr<Container> container_;
    std::vector<Block> order_;  // by their first messages
    std::int64_t num_messages_ = 0;
    std::size_t num_opened_ = 0;
    std::int64_t open_bytes_ = 0;
    std::vector<std::unique_ptr<OpenBlock>> heap_;  // the block of the earliest message on top
    std::unique_ptr<OpenBlock> current_;            // of the message that next() returned
};

}  // namespace divemesh::recording
