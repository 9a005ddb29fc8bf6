#include "api/uploads/import_dives.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <vector>

#include "api/audit.hpp"
#include "api/client/dive_tar.hpp"
#include "api/client/tus_upload.hpp"
#include "api/in_pool.hpp"
#include "api/uploads/make_dive.hpp"
#include "api/uploads/new_upload.hpp"
#include "api/uploads/upload_writer.hpp"
#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "storage/dive_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCopyBytes = std::size_t{1} << 20;
constexpr int kCopiesAtATime = 64;  // in the pool, before other work may run

void throw_if_stopping(const Services& services) {
    if (services.stopping) throw Error(ErrorCode::Cancelled, "the server is stopping");
}

bool is_archive(const std::string& name) {
    for (const char* ending : {".zip", ".tar", ".tar.gz", ".tgz", ".tar.zst"})
        if (name.ends_with(ending)) return true;
    return false;
}

bool is_dive_folder(const fs::path& folder) {
    return fs::is_directory(fs::symlink_status(folder / "mav0")) ||
           fs::is_directory(fs::symlink_status(folder / "cam0"));
}

// Refuses hard links: another name of the same file may lie outside the folder, and its content may
// not be part of a dive.
void require_single_name(const fs::path& file) {
    struct stat status {};
    if (lstat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_nlink != 1)
        throw Error(ErrorCode::InvalidArgument,
                    file.filename().string() +
                        " is a symbolic or hard link: replace it by a copy of the file");
}

void require_single_names(const fs::path& folder) {
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.symlink_status().type() == fs::file_type::regular)
            require_single_name(entry.path());
}

std::vector<fs::path> candidates(const fs::path& given) {
    const fs::path folder = fs::canonical(given);
    if (is_dive_folder(folder)) return {folder};
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder)) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
}

// One dive of the folder, and how far its import has come.
class DiveImport {
public:
    DiveImport(Services services, const ImportRequest& request, const fs::path& path)
        : services_(services), request_(request) {
        const auto type = fs::symlink_status(path).type();
        name_ = path.filename().string();
        const auto watch = [this](std::int64_t) { throw_if_stopping(services_); };
        if (type == fs::file_type::directory) {
            require_single_names(path);
            auto tar = std::make_unique<client::DiveTar>(path, Links::LeaveOut);
            hashes_ = tar->hash(watch);
            name_ += ".tar";
            source_ = std::move(tar);
        } else if (type == fs::file_type::regular && is_archive(name_)) {
            require_single_name(path);
            source_ = std::make_unique<client::FileSource>(path);
            hashes_ = client::hash_archive(*source_, watch);
        } else {
            throw Error(
                ErrorCode::InvalidArgument,
                "it is neither an archive (zip, tar, tar.gz, tar.zst) nor the folder of a dive");
        }
    }

    // Returns the dive of the same content that the project has already; "" if it has none.
    std::string known_dive() const {
        for (const auto& [content, archive] : {std::pair{hashes_.content_sha256, std::string()},
                                               std::pair{std::string(), hashes_.archive_sha256}}) {
            if (content.empty() && archive.empty()) continue;
            const storage::DiveFilter filter{
                .project = request_.project, .content_sha256 = content, .archive_sha256 = archive};
            for (const Dive& dive : storage::DiveStore(services_.catalog).list(filter, {}).items)
                if (dive.state != DiveState::Refused) return dive.id;
        }
        return "";
    }

    // Returns a new upload, or that of an interrupted import.
    std::string enter() {
        Upload wanted;
        wanted.project = request_.project;
        wanted.length_bytes = source_->size_bytes();
        wanted.lifetime_ms = services_.limits.upload_lifetime.count();
        wanted.metadata = metadata();
        for (const Upload& open : storage::UploadStore(services_.catalog).list_open())
            if (open.project == wanted.project && open.metadata == wanted.metadata &&
                open.length_bytes == wanted.length_bytes)
                return open.id;
        auto catalog = audited_import();
        return enter_upload(services_, catalog, wanted).id;
    }

    void begin(const std::string& upload_id) {
        const Upload upload = storage::UploadStore(services_.catalog).get(upload_id);
        storage::require_open(upload);
        upload_ = reconciled(services_, upload);
        if (!upload_.complete()) writer_.emplace(services_, upload_);
        offset_ = upload_.offset_bytes;
    }

    bool copy_some() {
        throw_if_stopping(services_);
        buffer_.resize(kCopyBytes);
        for (int i = 0; i < kCopiesAtATime && offset_ < source_->size_bytes(); ++i) {
            const std::size_t n = source_->read_at(offset_, buffer_);
            writer_->write({buffer_.data(), n});
            offset_ += static_cast<std::int64_t>(n);
        }
        return offset_ < source_->size_bytes();
    }

    Upload finish() {
        if (writer_) upload_ = writer_->finish();
        return upload_;
    }

    MadeDive enter_dive(const std::string& sha256) {
        auto catalog = audited_import();
        return make_dive(services_, catalog, upload_, plan_of(upload_.metadata), sha256);
    }

private:
    storage::Catalog audited_import() const {
        return audited(services_.catalog, "serve --import", name_);
    }

    std::string metadata() const {
        std::map<std::string, std::string> values = {
            {"filename", name_}, {"sha256", hashes_.archive_sha256}, {"commit", "import"}};
        if (!hashes_.content_sha256.empty()) values["dive"] = hashes_.content_sha256;
        if (!request_.preset.empty()) values["job"] = request_.preset;
        return client::tus_metadata(values);
    }

    Services services_;
    const ImportRequest& request_;
    std::string name_;
    std::unique_ptr<client::ByteSource> source_;
    client::DiveHashes hashes_;
    Upload upload_;
    std::optional<UploadWriter> writer_;
    std::vector<char> buffer_;
    std::int64_t offset_ = 0;
};

Awaitable<void> import_one(Services services, const ImportRequest& request, fs::path path) {
    auto open = [services, &request, path] {
        return std::make_shared<DiveImport>(services, request, path);
    };
    const auto import = co_await in_pool(services.pool, std::move(open));
    auto look = [import] { return import->known_dive(); };
    const std::string known = co_await in_pool(services.pool, std::move(look));
    const std::string name = path.filename().string();
    if (!known.empty()) {
        log_info({{"event", "import_known"}, {"name", name}, {"dive", known}});
        co_return;
    }
    auto enter = [import] { return import->enter(); };
    const std::string upload_id = co_await in_pool(services.pool, std::move(enter));
    const auto lock = co_await services.locks.take(upload_id, [] {});
    auto begin = [import, upload_id] { import->begin(upload_id); };
    co_await in_pool(services.pool, std::move(begin));
    for (bool more = true; more;) {
        auto copy = [import] { return import->copy_some(); };
        more = co_await in_pool(services.pool, std::move(copy));
    }
    auto finish = [import] { return import->finish(); };
    const Upload upload = co_await in_pool(services.pool, std::move(finish));
    const auto never = std::make_shared<std::atomic<bool>>(false);
    const std::string sha256 = co_await hash_archive(services, upload, never);
    auto make = [import, sha256] { return import->enter_dive(sha256); };
    const MadeDive made = co_await in_pool(services.transfers, std::move(make));
    log_info({{"event", "import_taken"},
              {"name", name},
              {"dive", made.dive.id},
              {"job", made.job_id},
              {"is_new", made.is_new}});
}

}  // namespace

Awaitable<void> import_dives(Services services, ImportRequest request) {
    auto list = [request] { return candidates(request.folder); };
    const std::vector<fs::path> paths = co_await in_pool(services.pool, std::move(list));
    int num_refused = 0;
    for (const fs::path& path : paths) {
        if (services.stopping) co_return;
        std::string failure;
        try {
            co_await import_one(services, request, path);
        } catch (const std::exception& error) {
            failure = error.what();
        }
        if (failure.empty()) continue;
        ++num_refused;
        log_info(
            {{"event", "import_refused"}, {"name", path.filename().string()}, {"what", failure}});
    }
    log_info({{"event", "import_ended"},
              {"folder", request.folder.string()},
              {"seen", paths.size()},
              {"refused", num_refused}});
}

}  // namespace divemesh::api
