#include "sensor/recording/table_tail.hpp"

#include <algorithm>
#include <fcntl.h>
#include <optional>
#include <sys/stat.h>
#include <unistd.h>

#include "schemas/file_descriptor.hpp"
#include "worker/dive/csv.hpp"

namespace divemesh::sensor {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{256} << 10;
constexpr int kMaxReads = 16;  // per call, because the caller has other work
constexpr std::size_t kMaxLineLength = 4096;

}  // namespace

bool TableTail::read(std::int64_t until_ns, const OnRow& on_row) {
    is_there_ = true;
    for (int i = 0; i < kMaxReads; ++i) {
        while (take_row(until_ns, on_row)) continue;
        const bool waits =
            pending_.find('\n', returned_) != std::string::npos;  // for a row in the future
        if (waits || !fetch()) break;
    }
    return is_there_;
}

bool TableTail::take_row(std::int64_t until_ns, const OnRow& on_row) {
    const std::size_t end = pending_.find('\n', returned_);
    if (end == std::string::npos) return false;
    const std::string_view line = std::string_view(pending_).substr(returned_, end - returned_);
    bool is_due = true;
    if (line.size() <= kMaxLineLength)
        dive::for_each_csv_row(line, [&](std::int64_t, auto fields) {
            const auto stamp = dive::parse_integer(fields[0]);
            if (!stamp) return;
            is_due = *stamp <= until_ns;
            if (is_due) on_row(*stamp, fields);
        });
    if (is_due) returned_ = end + 1;
    return is_due;
}

bool TableTail::fetch() {
    const FileDescriptor file(::open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    struct stat status {};
    is_there_ = file.is_open() && ::fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode);
    if (!is_there_) return false;
    if (status.st_ino != inode_ || status.st_size < offset_) {
        inode_ = status.st_ino;
        offset_ = 0;
        pending_.clear();
        returned_ = 0;
    }
    pending_.erase(0, returned_);
    returned_ = 0;
    if (pending_.size() > kMaxLineLength) pending_.clear();  // not a line of a table
    const std::size_t begin = pending_.size();
    pending_.resize(begin + kChunkBytes);
    const ssize_t got = ::pread(file.get(), pending_.data() + begin, kChunkBytes, offset_);
    pending_.resize(begin + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (got > 0) offset_ += got;
    return got > 0;
}

}  // namespace divemesh::sensor
