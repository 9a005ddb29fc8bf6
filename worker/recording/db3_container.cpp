#include "worker/recording/db3_container.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "schemas/error.hpp"
#include "worker/recording/unpack.hpp"

namespace divemesh::recording {
namespace {

// Rows are read in runs of this size, so that a run is never all of the file.
constexpr std::int64_t kRun_bytes = std::int64_t{4} << 20U;
// What a message takes beside its bytes.
constexpr std::int64_t kMessage_bytes = sizeof(BlockMessage);
// The damaged places of a file that are passed; the rest is left out beyond.
constexpr int kMaxDamages = 1000;
constexpr const char* kTopics = "SELECT id, name, type, serialization_format FROM topics";
constexpr const char* kMessages =
    "SELECT rowid, topic_id, timestamp, data FROM messages NOT INDEXED "
    "WHERE rowid >= ?1 AND rowid < ?2 ORDER BY rowid";
constexpr std::int64_t kEnd = std::numeric_limits<std::int64_t>::max();

// Returns a message as it was recorded; nullopt if it does not decompress. CDR begins with a zero,
// so a message is compressed where it begins as a frame of Zstandard.
std::optional<std::string> unpacked_message(std::string_view stored) {
    if (!stored.starts_with(kZstdMagic)) return std::string(stored);
    const auto stated_bytes = stated_zstd_bytes(stored);
    if (!stated_bytes || *stated_bytes > static_cast<std::uint64_t>(kMaxBlock_bytes))
        return std::nullopt;
    Unpacked unpacked = unpack(Codec::Zstd, stored, *stated_bytes);
    if (!unpacked.is_whole) return std::nullopt;
    return std::move(unpacked.bytes);
}

}  // namespace

Db3Container::Db3Container(InputFile file,
                           dive::FindingLog& findings,
                           const base::ProgressCallback& progress)
    : Container(std::move(file)), database_(file_.path()) {
    packed_bytes_ += database_.log_bytes();
    if (database_.is_cut()) report_cut(file_.size_bytes(), findings);
    learn_topics(findings);
    scan(findings, progress);
}

void Db3Container::learn_topics(dive::FindingLog& findings) try {
    auto rows = database_.query(kTopics);
    database_.query(kMessages);  // throws where its table is missing
    Db3Step step = rows.step();
    // Counted, as pages that refer to each other could go on forever.
    for (std::size_t i = 0; i < kMaxTopics && step == Db3Step::Row; ++i, step = rows.step()) {
        const auto serialization =
            rows.bytes(3) == "cdr" ? Serialization::Cdr : Serialization::Unknown;
        const auto topic = topic_of(rows.bytes(1), rows.bytes(2), serialization);
        if (topic) places_.emplace(rows.integer(0), *topic);
    }
    if (step == Db3Step::Damaged)
        report_damage(0, "the table of topics cannot be read to its end", findings);
} catch (const Error& error) {
    throw Error(ErrorCode::BadData,
                file_.path().string() + " is no ROS 2 bag: " + error.what() +
                    ": give the .db3 file of ros2 bag record");
}

void Db3Container::scan(dive::FindingLog& findings, const base::ProgressCallback& progress) {
    Block run;
    BlockContents contents;
    std::int64_t run_bytes = 0;
    const auto last = static_cast<double>(std::max<std::int64_t>(last_row(), 1));
    const auto end_run = [&] {
        add_block(run, contents);
        contents.messages.clear();
        run_bytes = 0;
    };
    const auto on_row = [&](const Db3Row& row) {
        progress({"import", 0.5 * std::min(1.0, static_cast<double>(row.number) / last)});
        const auto message = unpacked_message(row.bytes);
        if (!message)
            return report_damage(row.number,
                                 "the message of row " + std::to_string(row.number) +
                                     " does not decompress to the size that it states",
                                 findings);
        const auto num_bytes = std::ssize(*message) + kMessage_bytes;
        count_unpacked(std::ssize(*message));
        if (run_bytes + num_bytes > kRun_bytes) end_run();
        if (run_bytes == 0) run.begin = row.number;
        run.end = row.number + 1;
        run_bytes += num_bytes;
        contents.messages.push_back({row.topic, row.log_time_ns, 0, message->size()});
    };
    for_each_row({0, 1, kEnd}, on_row, [&](std::int64_t number) {
        if (database_.is_cut()) return;  // which is reported
        report_damage(
            number, "messages from row " + std::to_string(number) + " on cannot be read", findings);
    });
    end_run();
}

BlockContents Db3Container::read(const Block& block) const {
    BlockContents contents;
    const auto on_row = [&](const Db3Row& row) {
        const auto message = unpacked_message(row.bytes);
        if (!message) return;
        contents.messages.push_back(
            {row.topic, row.log_time_ns, contents.bytes.size(), message->size()});
        contents.bytes += *message;
    };
    for_each_row(block, on_row, [](std::int64_t) {});
    return contents;
}

// Passes a damaged place by steps that double, as rows are found by their numbers. Numbers that do
// not ascend are damage too: pages that refer to each other could go on forever.
void Db3Container::for_each_row(const Block& block,
                                const std::function<void(const Db3Row&)>& on_row,
                                const std::function<void(std::int64_t)>& on_damage) const {
    auto rows = database_.query(kMessages);
    std::int64_t next = block.begin;
    std::int64_t skip = 1;
    for (int num_damages = 0; num_damages < kMaxDamages; ++num_damages) {
        rows.restart();
        rows.bind(1, next);
        rows.bind(2, block.end);
        Db3Step step = rows.step();
        for (; step == Db3Step::Row && rows.integer(0) >= next; step = rows.step()) {
            next = rows.integer(0) + 1;
            skip = 1;
            const auto topic = places_.find(rows.integer(1));
            if (topic == places_.end() || !rows.is_blob(3) || rows.integer(2) < 0) continue;
            on_row({next - 1, topic->second, rows.integer(2), rows.bytes(3)});
        }
        if (step == Db3Step::Done) return;
        if (skip == 1) on_damage(next);
        if (skip >= block.end - next) return;
        next += skip;
        skip *= 2;
    }
}

// Returns the number of the last row, for progress; 0 if it cannot be read.
std::int64_t Db3Container::last_row() const {
    auto row = database_.query("SELECT max(rowid) FROM messages NOT INDEXED");
    return row.step() == Db3Step::Row ? row.integer(0) : 0;
}

}  // namespace divemesh::recording
