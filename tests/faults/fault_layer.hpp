#pragma once

#include <array>
#include <cerrno>
#include <filesystem>

// Lets the n-th call of a kind fail, in the process that links this: the calls of the C library and
// of SQLite are replaced by ones that count, those that other libraries make included. All threads
// count together. After SQLite's own tests (sqlite.org/testing.html, "I/O Error Testing").
namespace divemesh::faults {

enum class Call {
    Allocate,   // operator new: std::bad_alloc
    Open,       // open, openat
    Read,       // read, pread
    Write,      // write, pwrite, ftruncate; half of the bytes are written
    Sync,       // fsync, fdatasync; what was appended since the last one is lost
    Rename,     // rename, renameat
    Remove,     // unlink, unlinkat
    Make,       // mkdir, mkdirat
    Statement,  // sqlite3_step, sqlite3_exec: SQLITE_IOERR
};

// The kinds that a disk makes fail, the catalog's included.
inline constexpr std::array kCallsOfDisk = {Call::Open,
                                            Call::Read,
                                            Call::Write,
                                            Call::Sync,
                                            Call::Rename,
                                            Call::Remove,
                                            Call::Make,
                                            Call::Statement};

const char* name_of(Call call);

// Returns whether nothing becomes durable without a call of this kind: a sweep must meet some.
constexpr bool is_made_by_every_step(Call call) {
    return call == Call::Write || call == Call::Sync || call == Call::Statement;
}

enum class Lasting {
    Once,    // that call alone
    ForGood  // and all later ones
};

struct Fault {
    Call call = Call::Write;
    int number = 1;  // counted from now: 1 is the next one
    Lasting lasting = Lasting::Once;
    int error = EIO;
};

// Takes the files of a folder, as they are, for files that are durable: a failing Sync loses
// nothing of them.
void take_as_durable(const std::filesystem::path& folder);

// Arms one fault while it lives.
class Armed {
public:
    explicit Armed(const Fault& fault);
    ~Armed();
    Armed(const Armed&) = delete;
    Armed& operator=(const Armed&) = delete;

    bool happened() const;  // whether a call has failed
};

}  // namespace divemesh::faults
