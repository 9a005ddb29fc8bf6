#include "worker/recording/npz_file.hpp"

#include <algorithm>
#include <archive.h>
#include <archive_entry.h>
#include <cmath>
#include <memory>
#include <new>

#include "schemas/error.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/recording/npy_array.hpp"

namespace divemesh::recording {
namespace {

constexpr std::string_view kEnding = ".npy";
constexpr int kMaxArrays = 1000;
// Of one array. Larger ones hold corners of boards, and are passed over unread.
constexpr std::size_t kMaxArray_bytes = std::size_t{64} << 10U;
constexpr std::size_t kMaxName_bytes = 100;

// Reads the entries of a zip in memory, in their order.
class ZipEntries {
public:
    ZipEntries(std::string_view bytes, const std::string& file)
        : file_(file), reader_(archive_read_new(), &archive_read_free) {
        if (!reader_) throw std::bad_alloc();
        archive_read_support_format_zip(reader_.get());
        check(archive_read_open_memory(reader_.get(), bytes.data(), bytes.size()));
    }

    // Goes to the next entry; returns false at the end.
    bool next() {
        const int code = archive_read_next_header(reader_.get(), &entry_);
        if (code == ARCHIVE_EOF) return false;
        check(code);
        return true;
    }
    std::string name() const {
        const char* name = archive_entry_pathname(entry_);
        return name == nullptr ? "" : name;
    }
    // Returns the bytes of the entry; empty if there are more than `max_bytes`.
    std::string bytes(std::size_t max_bytes) {
        std::string bytes(max_bytes + 1, '\0');
        std::size_t size = 0;
        while (size < bytes.size()) {
            const auto got =
                archive_read_data(reader_.get(), bytes.data() + size, bytes.size() - size);
            if (got < 0) check(static_cast<int>(got));
            if (got <= 0) break;
            size += static_cast<std::size_t>(got);
        }
        bytes.resize(size > max_bytes ? 0 : size);
        return bytes;
    }

private:
    void check(int code) const {
        if (code == ARCHIVE_OK || code == ARCHIVE_WARN) return;
        const char* why = archive_error_string(reader_.get());
        throw Error(ErrorCode::BadData,
                    file_ + " is damaged: " + dive::printable(why == nullptr ? "" : why) +
                        ": write the calibration again");
    }

    const std::string& file_;
    std::unique_ptr<archive, int (*)(archive*)> reader_;
    archive_entry* entry_ = nullptr;
};

YAML::Node node_of(const std::vector<double>& numbers) {
    if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); }))
        throw Error(ErrorCode::BadData, "it has a value that is not a number");
    if (numbers.size() == 1) return YAML::Node(numbers[0]);
    YAML::Node list(YAML::NodeType::Sequence);
    for (const double number : numbers) list.push_back(number);
    return list;
}

}  // namespace

bool is_npz(std::string_view bytes) { return bytes.starts_with("PK\x03\x04"); }

YAML::Node parse_npz(std::string_view bytes, const std::string& file) {
    YAML::Node arrays(YAML::NodeType::Map);
    ZipEntries entries(bytes, file);
    for (int i = 0; entries.next(); ++i) {
        if (i == kMaxArrays)
            throw Error(ErrorCode::BadData,
                        file + " holds more than " + std::to_string(kMaxArrays) +
                            " arrays: give one that holds a calibration alone");
        std::string name = entries.name();
        if (!name.ends_with(kEnding) || name.size() > kMaxName_bytes) continue;
        const std::string array = entries.bytes(kMaxArray_bytes);
        if (array.empty()) continue;
        name.resize(name.size() - kEnding.size());
        const std::string what = file + ": the array " + dive::printable(name);
        try {
            if (const auto numbers = parse_npy(array)) arrays[name] = node_of(*numbers);
        } catch (const Error& error) {
            throw Error(error.code(), what + " cannot be read: " + error.what());
        }
    }
    return arrays;
}

}  // namespace divemesh::recording
