// Takes the place of the pipeline behind a real worker. The first word of the "archive" says what
// it does.
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <netinet/in.h>
#include <new>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include "schemas/file_descriptor.hpp"
#include "schemas/json.hpp"
#include "worker/attempt/attempt_protocol.hpp"
#include "worker/compare/compare.hpp"
#include "worker/dive/intake.hpp"
#include "worker/pipeline/check_cameras.hpp"
#include "worker/pipeline/reconstruct_dive.hpp"
#include "worker/report/accuracy_report.hpp"
#include "worker/report/truth_check.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct Script {
    std::string word;
    fs::path marker;
};

Script read_script(const fs::path& dive) {
    Script script;
    std::ifstream(dive) >> script.word >> script.marker;
    return script;
}

void write_pid(const fs::path& marker) {
    std::ofstream(marker.string() + ".new") << getpid();
    fs::rename(marker.string() + ".new", marker);
}

void write_artifacts(const fs::path& out) {
    fs::create_directories(out / "keyframes");
    std::ofstream(out / "mesh.ply") << "ply\n";
    std::ofstream(out / "keyframes/000001.jpg") << "jpeg";
}

// Writes a file that the worker may not copy: it exceeds the limit with which both processes
// started.
void write_large_file(const fs::path& out) {
    rlimit limit{};
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_FSIZE, &limit);
    std::ofstream(out / "mesh.ply") << "ply\n";
    std::ofstream(out / "cloud.ply") << "ply\n";
    fs::resize_file(out / "mesh.ply", 64 << 20);
}

void write_settings(const fs::path& file, const ReconstructionOptions& options) {
    std::ofstream(file, std::ios::app)
        << options.num_threads << ' ' << options.fusion_memory_bytes << '\n';
}

void fill_scratch(const fs::path& scratch, const base::ProgressCallback& progress) {
    std::ofstream file(scratch / "volume");
    for (const std::string block(1 << 20, 'x');;) {
        progress({.stage = "fuse"});
        if (file.tellp() < (8 << 20)) file << block << std::flush;
        std::this_thread::sleep_for(20ms);
    }
}

// Sends messages without end, as a child process would after a recording took control of it.
void talk() {
    for (int i = 0; i < 20'000; ++i) {
        const std::string line =
            attempt::encode_message(Progress{.stage = "fuse", .frames_done = i});
        if (write(attempt::kAttemptPipe, line.data(), line.size()) < 0) return;
    }
}

std::string tcp_to_nowhere() {
    const FileDescriptor stream(socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_port = htons(9);
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int result = connect(stream.get(), reinterpret_cast<sockaddr*>(&there), sizeof there);
    const int failure = result == 0 ? 0 : errno;
    return failure == ECONNREFUSED || failure == 0 ? "network" : "no network";
}

std::string program_of_others() {
    const int status = std::system("exit 0");
    return status == 0 ? "processes" : "no processes";
}

bool has_secret() {
    for (const char* name :
         {"AWS_SECRET_ACCESS_KEY", "PGPASSWORD", "DIVEMESH_CATALOG", "DIVEMESH_TOKEN"})
        if (std::getenv(name) != nullptr) return true;
    return false;
}

void write_limits(const pipeline::ReconstructionRequest& request) {
    std::ofstream file(request.out / "limits.txt");
    for (const auto resource : {RLIMIT_DATA, RLIMIT_FSIZE, RLIMIT_NOFILE, RLIMIT_CPU}) {
        rlimit limit{};
        getrlimit(resource, &limit);
        file << limit.rlim_cur << ' ';
    }
    file << request.cache_bytes << ' ' << request.cache.filename().string() << ' '
         << tcp_to_nowhere() << '\n'
         << program_of_others() << '\n'
         << (has_secret() ? "keys" : "no keys") << ' '
         << (std::getenv("PATH") == nullptr ? "no path" : "path") << '\n';
}

// In the first attempt, waits for the file MARKER.go; later attempts find the marker and do not
// wait.
void wait_once(const fs::path& marker, const base::ProgressCallback& progress) {
    if (fs::exists(marker)) return;
    write_pid(marker);
    while (!fs::exists(marker.string() + ".go")) {
        progress({.stage = "track", .fraction = 0.5, .frames_done = 1, .num_frames = 2});
        std::this_thread::sleep_for(20ms);
    }
}

}  // namespace

dive::IntakeReport dive::examine_dive(const fs::path&,
                                      const fs::path&,
                                      const base::ProgressCallback& progress,
                                      const dive::RecordingCheck&,
                                      Links) {
    progress({.stage = "intake", .fraction = 1.0});
    return {.findings = {{.severity = Severity::Info, .code = "fake"}},
            .name = "fake",
            .rig = "fake rig",
            .num_frames = 2,
            .duration_s = 0.1,
            .thumbnail_jpeg = "jpeg"};
}

std::vector<Finding> pipeline::check_cameras(const types::Recording&,
                                             const base::ProgressCallback&) {
    return {};
}

nlohmann::json pipeline::reconstruct_dive(const pipeline::ReconstructionRequest& request,
                                          const base::ProgressCallback& progress) {
    const Script script = read_script(request.dive);
    progress({.stage = "track", .fraction = 0.1});
    if (script.word == "wait-once") wait_once(script.marker, progress);
    if (script.word == "bad") throw Error(ErrorCode::BadData, "mav0/cam1 is missing");
    if (script.word == "talk") talk();
    if (script.word == "hostile")
        throw Error(ErrorCode::BadData, "no\x1b[31m\n{\"event\": \"all_is_well\"}");
    if (script.word == "bug") throw std::logic_error("index out of range");
    if (script.word == "abort") std::abort();
    if (script.word == "exit") _exit(7);
    if (script.word == "killed") raise(SIGKILL);
    if (script.word == "greedy")
        write_settings(script.marker, request.options), throw std::bad_alloc();
    if (script.word == "fill") fill_scratch(request.scratch, progress);
    if (script.word == "limits") write_limits(request);
    if (script.word == "deaf") {
        write_pid(script.marker);
        std::this_thread::sleep_for(10min);
    }
    if (script.word == "empty") {
        std::ofstream(request.out / "mesh.ply") << "ply\n";
        return nlohmann::json::object();
    }
    write_artifacts(request.out);
    if (script.word == "unusable")
        return {
            {"verdict", "not_usable"},
            {"findings",
             {Finding{Severity::Error, "no_surface", "", "the mesh has no triangles", "swim"}}}};
    if (script.word == "large") write_large_file(request.out);
    progress({.stage = "evaluate", .fraction = 1.0});
    request.stage_done({.name = "evaluate", .seconds = 0.5});
    return {{"version", "fake 1"},
            {"trajectory", {{"path_length_m", 2.5}}},
            {"calibration", {{"sha256", "fake calibration"}}}};
}

nlohmann::json compare::compare_reconstructions(const compare::CompareRequest& request,
                                                const base::ProgressCallback&) {
    if (!fs::exists(request.a / "mesh.ply") || !fs::exists(request.b / "mesh.ply"))
        throw Error(ErrorCode::Unavailable, "a mesh is missing");
    if (request.options.reach_m > 10.0) throw Error(ErrorCode::Conflict, "other ground");
    std::ofstream(request.out / "compare.json") << request.options.cell_m;
    return {};
}

std::string report::problem_of_truth(TruthKind, const fs::path& file) {
    return fs::file_size(file) == 0 ? "the truth is empty" : "";
}

// Writes what it was given: the mesh, the truth, the findings, the history.
nlohmann::json report::make_accuracy_report(const report::AccuracyReportRequest& request,
                                            const base::ProgressCallback&) {
    if (request.ground_truth && fs::file_size(*request.ground_truth) == 0)
        throw Error(ErrorCode::BadData, "the truth is empty");
    std::ofstream file(request.out / "report.json");
    file << std::ifstream(request.reconstruction / "mesh.ply").rdbuf();
    if (request.ground_truth)
        file << request.ground_truth->filename().string() << ' '
             << std::ifstream(*request.ground_truth).rdbuf();
    for (const Finding& finding : request.findings) file << ' ' << finding.message;
    for (const auto& [name, values] : request.history) file << ' ' << name << ' ' << values.size();
    const auto metric = nlohmann::json{
        {"figure", "trajectory.path_length_m"}, {"value", 2.5}, {"unit", "m"}, {"method", ""}};
    nlohmann::json requirements = nlohmann::json::array();
    for (const std::string& text : request.requirements)
        requirements.push_back(
            {{"text", text}, {"figure", text}, {"value", 2.5}, {"met", false}, {"reason", "fake"}});
    return {{"version", "fake 2"},
            {"reconstruction", {{"calibration_sha256", "fake calibration"}}},
            {"figures", nlohmann::json::array({metric})},
            {"requirements", requirements},
            {"regressions", nlohmann::json::array()}};
}

}  // namespace divemesh
