#include <algorithm>
#include <archive.h>
#include <archive_entry.h>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <locale.h>
#include <string_view>
#include <unordered_set>

#include "schemas/content_hash.hpp"
#include "worker/dive/archive_reader.hpp"
#include "worker/dive/dive_source.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/pack_file.hpp"
#include "worker/dive/refusal.hpp"

namespace divemesh::dive {
namespace {

// Sets a UTF-8 locale for the thread, as libarchive converts names to the thread's locale.
class Utf8Names {
public:
    Utf8Names() : locale_(::newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr)) {
        if (locale_ != nullptr) previous_ = ::uselocale(locale_);
    }
    ~Utf8Names() {
        if (locale_ == nullptr) return;
        ::uselocale(previous_);
        ::freelocale(locale_);
    }
    Utf8Names(const Utf8Names&) = delete;
    Utf8Names& operator=(const Utf8Names&) = delete;

private:
    locale_t locale_;
    locale_t previous_ = nullptr;
};

std::string folded(std::string_view name) {
    std::string result(name);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return result;
}

class ArchiveSource : public DiveSource {
public:
    ArchiveSource(const std::filesystem::path& archive,
                  const std::filesystem::path& scratch,
                  const DiveLimits& limits,
                  const base::ProgressCallback& progress)
        : name_(archive.filename().string()), pack_(scratch) {
        Unpacker unpacker(*this, archive, limits, progress);
        unpacker.run();
        sort_files();
    }

    void read(const SourceFile& file, const Sink& sink) const override {
        std::vector<char> chunk(
            static_cast<std::size_t>(std::min<std::int64_t>(1 << 20, file.size_bytes)));
        for (std::int64_t done = 0; done < file.size_bytes;) {
            const auto length = std::min<std::int64_t>(std::ssize(chunk), file.size_bytes - done);
            const std::span<char> part(chunk.data(), static_cast<std::size_t>(length));
            pack_.read(file.offset_bytes + done, part);
            sink(part);
            done += length;
        }
    }

private:
    // One pass over the archive.
    class Unpacker {
    public:
        Unpacker(ArchiveSource& source,
                 const std::filesystem::path& path,
                 const DiveLimits& limits,
                 const base::ProgressCallback& progress);
        void run();

    private:
        // Refuse with the message "<archive> <what>" or "<archive> has an entry '<name>' <what>".
        [[noreturn]] void refuse(const std::string& code,
                                 const std::string& what,
                                 const std::string& remedy) const;
        [[noreturn]] void refuse_entry(const std::string& code,
                                       const std::string& what,
                                       const std::string& remedy) const;
        [[noreturn]] void refuse_unreadable() const;
        std::string reason() const;  // libarchive's message
        bool next_entry();
        void check_kind() const;
        std::string checked_name();
        void unpack(const std::string& name);
        void check_sizes(std::int64_t file_bytes) const;
        void report();

        ArchiveSource& source_;
        const DiveLimits& limits_;
        const base::ProgressCallback& progress_;
        Utf8Names utf8_names_;
        FileDescriptor file_;
        std::int64_t archive_bytes_ = 0;
        ArchiveReader reader_;
        archive_entry* entry_ = nullptr;
        std::string entry_name_;  // as written in the archive
        std::int64_t num_entries_ = 0;
        std::unordered_set<std::string> folded_names_;
    };

    std::string name_;
    PackFile pack_;
};

ArchiveSource::Unpacker::Unpacker(ArchiveSource& source,
                                  const std::filesystem::path& path,
                                  const DiveLimits& limits,
                                  const base::ProgressCallback& progress)
    : source_(source),
      limits_(limits),
      progress_(progress),
      file_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)),
      reader_(make_archive_reader()) {
    if (!file_.is_open())
        throw Error(ErrorCode::Unavailable,
                    "cannot open " + path.string() + ": " + std::strerror(errno));
    archive_bytes_ = static_cast<std::int64_t>(std::filesystem::file_size(path));
    if (archive_read_open_fd(reader_.get(), file_.get(), 1 << 18) != ARCHIVE_OK)
        refuse_unreadable();
}

void ArchiveSource::Unpacker::run() {
    while (next_entry()) {
        check_kind();
        const std::string name = checked_name();
        if (archive_entry_filetype(entry_) == AE_IFREG) unpack(name);
        report();
    }
    if (num_entries_ == 0)
        refuse("archive_empty", "is empty", "Pack the folder of the dive into it.");
}

void ArchiveSource::Unpacker::refuse(const std::string& code,
                                     const std::string& what,
                                     const std::string& remedy) const {
    const std::string name = printable(source_.name_);
    throw Refusal(code, name, name + " " + what, remedy);
}

void ArchiveSource::Unpacker::refuse_entry(const std::string& code,
                                           const std::string& what,
                                           const std::string& remedy) const {
    const std::string entry = printable(entry_name_);
    const std::string name = printable(source_.name_);
    throw Refusal(code, entry, name + " has an entry '" + entry + "' " + what, remedy);
}

void ArchiveSource::Unpacker::refuse_unreadable() const {
    refuse(
        "not_an_archive",
        "is not a complete zip, tar, tar.gz or tar.zst archive (" + reason() + ")",
        "Make the archive again and upload it again; videos and images become a dive by divemesh "
        "import.");
}

std::string ArchiveSource::Unpacker::reason() const {
    const char* text = archive_error_string(reader_.get());
    return text != nullptr ? printable(text) : "damaged";
}

bool ArchiveSource::Unpacker::next_entry() {
    const int result = archive_read_next_header(reader_.get(), &entry_);
    if (result == ARCHIVE_EOF) return false;
    if (result != ARCHIVE_OK && result != ARCHIVE_WARN) {
        if (num_entries_ == 0) refuse_unreadable();
        refuse("archive_damaged",
               "is damaged after the entry '" + printable(entry_name_) + "' (" + reason() + ")",
               "Make the archive again and upload it again.");
    }
    if (++num_entries_ > limits_.max_entries)
        refuse("archive_too_many_entries",
               "has more than " + std::to_string(limits_.max_entries) + " entries",
               "Pack only one dive into an archive.");
    if (archive_filter_count(reader_.get()) > kMaxArchiveFilters)
        refuse("archive_nested", "is compressed more than once", "Compress it once.");
    const char* name = archive_entry_pathname(entry_);
    if (name == nullptr)
        refuse("archive_entry_name",
               "has an entry with an unreadable name, after '" + printable(entry_name_) + "'",
               "Rename the file with plain letters and digits.");
    entry_name_ = name;
    return true;
}

void ArchiveSource::Unpacker::check_kind() const {
    const auto refuse_kind = [&](const std::string& kind) {
        refuse_entry("archive_entry_kind", "that is " + kind, "Leave it out of the archive.");
    };
    const auto kind = archive_entry_filetype(entry_);
    if (archive_entry_hardlink(entry_) != nullptr) refuse_kind("a hard link");
    if (archive_entry_symlink(entry_) != nullptr || kind == AE_IFLNK) refuse_kind("a link");
    if (archive_entry_is_encrypted(entry_) != 0)
        refuse_entry(
            "archive_encrypted", "that is encrypted", "Make the archive without a password.");
    if (kind != AE_IFREG && kind != AE_IFDIR) refuse_kind("a device, pipe or socket");
}

std::string ArchiveSource::Unpacker::checked_name() {
    std::string_view name = plain_entry_name(entry_name_);
    const bool is_folder = archive_entry_filetype(entry_) == AE_IFDIR;
    if (is_folder && name.ends_with('/')) name.remove_suffix(1);
    if (is_folder && (name.empty() || name == ".")) return "";
    if (const auto problem = entry_name_problem(name); !problem.empty())
        refuse_entry("archive_entry_name",
                     "whose name " + problem,
                     "Make the archive from inside the folder of the dive, with plain file names.");
    if (!is_folder && !folded_names_.insert(folded(name)).second)
        refuse_entry("archive_duplicate",
                     "that occurs twice (upper and lower case count as the same)",
                     "Keep only one of them.");
    return std::string(name);
}

void ArchiveSource::Unpacker::unpack(const std::string& name) {
    if (archive_entry_size_is_set(entry_) != 0) check_sizes(archive_entry_size(entry_));
    SourceFile file{name, 0, source_.pack_.size_bytes(), ""};
    Sha256 hash;
    std::vector<char> chunk(1 << 16);
    while (true) {
        const la_ssize_t got = archive_read_data(reader_.get(), chunk.data(), chunk.size());
        if (got == 0) break;
        if (got < 0)
            refuse_entry("archive_damaged",
                         "that cannot be read (" + reason() + ")",
                         "Make the archive again and upload it again.");
        const std::span<const char> bytes(chunk.data(), static_cast<std::size_t>(got));
        file.size_bytes += got;
        check_sizes(file.size_bytes);
        hash.update(bytes);
        source_.pack_.append(bytes);
        report();
    }
    file.sha256 = hash.hex();
    source_.files_.push_back(std::move(file));
}

void ArchiveSource::Unpacker::check_sizes(std::int64_t file_bytes) const {
    const std::int64_t unpacked = source_.pack_.size_bytes();
    if (file_bytes > limits_.max_file_bytes)
        refuse_entry("archive_too_large",
                     "that is larger than " + std::to_string(limits_.max_file_bytes) + " bytes",
                     "Leave it out or split it.");
    if (unpacked > limits_.max_unpacked_bytes)
        refuse_entry("archive_too_large",
                     "that makes it larger than " + std::to_string(limits_.max_unpacked_bytes) +
                         " bytes unpacked",
                     "Split the recording into shorter dives.");
    if (unpacked > kRatioCheckedFromBytes &&
        static_cast<double>(unpacked) >
            limits_.max_compression_ratio * static_cast<double>(archive_bytes_))
        refuse_entry("archive_bomb",
                     "that makes it more than " +
                         std::to_string(static_cast<int>(limits_.max_compression_ratio)) +
                         " times its packed size, like a decompression bomb",
                     "Store images as PNG or JPEG, which hardly shrink when packed.");
}

void ArchiveSource::Unpacker::report() {
    Progress progress;
    progress.fraction =
        std::min(1.0,
                 static_cast<double>(archive_filter_bytes(reader_.get(), -1)) /
                     static_cast<double>(std::max<std::int64_t>(1, archive_bytes_)));
    progress_(progress);
}

}  // namespace

std::unique_ptr<DiveSource> open_archive(const std::filesystem::path& archive,
                                         const std::filesystem::path& scratch,
                                         const DiveLimits& limits,
                                         const base::ProgressCallback& progress) {
    return std::make_unique<ArchiveSource>(archive, scratch, limits, progress);
}

}  // namespace divemesh::dive
