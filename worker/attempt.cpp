#include "worker/attempt.hpp"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <unistd.h>

#include "schemas/error.hpp"
#include "schemas/reconstruction_options.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/dive/intake.hpp"
#include "worker/forbid_processes.hpp"
#include "worker/reconstruct_dive.hpp"

namespace divemesh::worker {
namespace {

using namespace std::chrono_literals;
constexpr auto kReportInterval = 250ms;

std::atomic<bool> cancel_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void request_cancel(int) { cancel_requested = true; }

// A parent that is gone is told by SIGPIPE being ignored and write() failing: then nobody waits
// for the result.
void send(const AttemptMessage& message) {
    const std::string line = encode_message(message);
    for (std::size_t sent = 0; sent < line.size();) {
        const auto n = ::write(kAttemptPipe, line.data() + sent, line.size() - sent);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
            throw Error(ErrorCode::Cancelled, "the worker that started this attempt is gone");
        sent += static_cast<std::size_t>(n);
    }
}

AttemptRequest read_request(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream) throw Error(ErrorCode::NotFound, "no request file " + file.string());
    return nlohmann::json::parse(stream).get<AttemptRequest>();
}

ProgressCallback reporter() {
    return [last = std::chrono::steady_clock::time_point{},
            stage = std::string()](const Progress& progress) mutable {
        if (cancel_requested) throw Error(ErrorCode::Cancelled, "cancelled");
        const auto now = std::chrono::steady_clock::now();
        if (now - last < kReportInterval && progress.stage == stage) return;
        if (progress.stage != stage) send(LogText{"stage " + progress.stage + "\n"});
        last = now;
        stage = progress.stage;
        send(progress);
    };
}

void write_thumbnail(const std::filesystem::path& file, const std::string& jpeg) {
    std::ofstream stream(file, std::ios::binary);
    stream.write(jpeg.data(), static_cast<std::streamsize>(jpeg.size()));
    stream.close();
    if (!stream) throw Error(ErrorCode::OutOfSpace, "cannot write " + file.string());
}

void run_intake(const AttemptRequest& request) {
    const IntakeReport report = examine_dive(request.dive, request.scratch, reporter());
    if (!report.thumbnail_jpeg.empty())
        write_thumbnail(request.out / "thumbnail.jpg", report.thumbnail_jpeg);
    send(IntakeAnswer{.findings = report.findings,
                      .name = report.name,
                      .site = report.site,
                      .tags = report.tags,
                      .content_sha256 = report.content_sha256,
                      .num_frames = report.num_frames,
                      .duration_s = report.duration_s,
                      .has_thumbnail = !report.thumbnail_jpeg.empty()});
}

void run_reconstruction(const AttemptRequest& request) {
    reconstruct_dive({.dive = request.dive,
                      .out = request.out,
                      .scratch = request.scratch,
                      .cache = request.cache,
                      .cache_bytes = request.cache_bytes,
                      .preset = request.preset,
                      .options = make_options(request.preset, request.options),
                      .stage_done = [](const StageRun& stage) { send(stage); }},
                     reporter());
    send(Reconstructed{});
}

void run(const AttemptRequest& request) {
    switch (request.kind) {
        case JobKind::Intake: return run_intake(request);
        case JobKind::Reconstruct: return run_reconstruction(request);
        case JobKind::AccuracyReport:
        case JobKind::Compare: break;
    }
    throw Error(ErrorCode::InvalidArgument,
                "this version does not do jobs of kind " + std::string(to_string(request.kind)));
}

}  // namespace

int run_attempt(const std::filesystem::path& request_file) try {
    std::signal(SIGTERM, request_cancel);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // a full quota is an error of write(), not the end
    try {
        if (!forbid_processes())
            send(LogText{"this kernel cannot keep the attempt from starting processes\n"});
        run(read_request(request_file));
        return 0;
    } catch (const Error& error) {
        send(Failure{.code = error.code(), .message = error.what()});
    } catch (const std::bad_alloc&) {
        send(Failure{.code = ErrorCode::OutOfMemory, .message = "memory ran out"});
    } catch (const std::exception& error) {
        send(Failure{.code = ErrorCode::Unavailable,
                     .message = std::string("internal error: ") + error.what(),
                     .remedy = "if this repeats, report it with this dive"});
    }
    return 1;
} catch (...) {  // nobody is left to tell
    return 1;
}

}  // namespace divemesh::worker
