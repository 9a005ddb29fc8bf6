#include "worker/recording/message_log.hpp"

#include <algorithm>
#include <utility>

namespace divemesh::recording {
namespace {

constexpr std::int64_t kMaxOpen_bytes = std::int64_t{1} << 30U;

template <typename Items, typename Time>
void sort_by_time(Items& items, const Time& time_ns) {
    std::stable_sort(items.begin(), items.end(), [&](const auto& a, const auto& b) {
        return time_ns(a) < time_ns(b);
    });
}

}  // namespace

MessageLog::MessageLog(const std::filesystem::path& path,
                       dive::FindingLog& findings,
                       const base::ProgressCallback& progress)
    : container_(open_container(path, findings, progress)), order_(container_->blocks()) {
    sort_by_time(order_, [](const Block& block) { return block.first_ns; });
    for (const Topic& topic : topics()) num_messages_ += topic.num_messages;
}

std::optional<LoggedMessage> MessageLog::next() {
    put_back_current();
    while (must_open_a_block()) open_next_block();
    if (heap_.empty()) return std::nullopt;
    std::pop_heap(heap_.begin(), heap_.end(), &is_later);
    current_ = std::move(heap_.back());
    heap_.pop_back();
    const BlockContents& contents = current_->contents;
    const BlockMessage& message = contents.messages[current_->next_message++];
    return LoggedMessage{
        message.topic,
        message.log_time_ns,
        std::string_view(contents.bytes).substr(message.offset_bytes, message.size_bytes)};
}

void MessageLog::rewind() {
    heap_.clear();
    current_.reset();
    num_opened_ = 0;
    open_bytes_ = 0;
}

bool MessageLog::is_later(const std::unique_ptr<OpenBlock>& a,
                          const std::unique_ptr<OpenBlock>& b) {
    return std::pair(a->time_ns(), a->place) > std::pair(b->time_ns(), b->place);
}

bool MessageLog::must_open_a_block() const {
    if (num_opened_ == order_.size()) return false;
    if (heap_.empty()) return true;
    return order_[num_opened_].first_ns <= heap_.front()->time_ns() && open_bytes_ < kMaxOpen_bytes;
}

void MessageLog::open_next_block() {
    auto opened = std::make_unique<OpenBlock>();
    opened->place = num_opened_;
    opened->contents = container_->read(order_[num_opened_++]);
    if (opened->contents.messages.empty()) return;  // the file has changed since it was opened
    sort_by_time(opened->contents.messages,
                 [](const BlockMessage& message) { return message.log_time_ns; });
    open_bytes_ += std::ssize(opened->contents.bytes);
    heap_.push_back(std::move(opened));
    std::push_heap(heap_.begin(), heap_.end(), &is_later);
}

// Puts the block of the last message back on the heap, or closes it if it was the block's last.
void MessageLog::put_back_current() {
    if (!current_) return;
    if (current_->next_message < current_->contents.messages.size()) {
        heap_.push_back(std::move(current_));
        std::push_heap(heap_.begin(), heap_.end(), &is_later);
    } else {
        open_bytes_ -= std::ssize(current_->contents.bytes);
    }
    current_.reset();
}

}  // namespace divemesh::recording
