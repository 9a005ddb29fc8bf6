#include "tests/bench/envelope_runs.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "schemas/error.hpp"
#include "tests/bench/program.hpp"
#include "tests/bench/sift_baseline.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Rendered twice as often as the plain dive, with the depths that tell overlap.
const std::vector<std::string> kPlainDive = {"--rate", "20", "--truth"};
const std::vector<std::string> kBlueDive = {"--rate", "20", "--blue-water", "0:3600"};
constexpr int kOtherSeed = 1000;  // added to the seed for the dive whose IMU is the wrong one

std::string file_name(std::string text) {
    for (char& c : text)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
    return text;
}

fs::path made(fs::path folder) {
    fs::create_directories(folder);
    return folder;
}

json at(const json& document, const char* pointer) {
    const json::json_pointer place(pointer);
    return document.contains(place) ? document[place] : json();
}

double number_at(const json& document, const char* pointer) {
    const json value = at(document, pointer);
    return value.is_number() ? value.get<double>() : 0.0;
}

json verdict_of(const json& metrics) {
    const json verdict = metrics.value("verdict", json());
    return verdict.is_object() ? verdict.value("verdict", json()) : verdict;
}

json findings_of(const json& metrics) {
    json codes = json::array();
    for (const json& finding : metrics.value("findings", json::array()))
        if (finding.value("severity", "") != "info") codes.push_back(finding["code"]);
    return codes;
}

// Without metrics.json nothing was tracked.
json tracked_run(const json& metrics, int exit_code) {
    const double num_frames = number_at(metrics, "/frames/num_frames");
    const double num_tracked = number_at(metrics, "/frames/num_frames_tracked");
    return {{"exit_code", exit_code},
            {"num_frames", num_frames},
            {"tracked_share", num_frames > 0.0 ? num_tracked / num_frames : 0.0},
            {"num_segments", metrics.value("pieces", json::array()).size()},
            {"ate_m", at(metrics, "/trajectory/final/ate_rmse_m")},
            {"bound_m", at(metrics, "/expected_accuracy/trajectory/ate/bound_m")},
            {"scale", at(metrics, "/trajectory/final/sim3_scale")},
            {"verdict", verdict_of(metrics)},
            {"findings", findings_of(metrics)}};
}

double path_length_m(const types::Trajectory& path) {
    double sum_m = 0.0;
    for (std::size_t i = 1; i < path.size(); ++i)
        sum_m += (path[i].T_world_imu.translation() - path[i - 1].T_world_imu.translation()).norm();
    return sum_m;
}

json sift_run(dive::Dive& dive) {
    const SiftPath path = sift_path(dive);
    json result = {{"linked_share", path.linked_share()}, {"ate_m", nullptr}, {"scale", nullptr}};
    const SiftChain* chain = path.longest();
    if (chain == nullptr) return result;
    try {
        const auto error =
            evaluation::trajectory_error(chain->T_first_cam0,
                                         dive.ground_truth(),
                                         {.T_referencebody_estimatebody = dive.rig().T_imu_cam0});
        result["ate_m"] = error.ate_rmse_m;
        result["scale"] = error.sim3_scale;
    } catch (const Error&) {  // too few frames are linked
    }
    return result;
}

// Null unless the dive was rendered with masks.
json moving_share(const fs::path& dive) {
    const fs::path masks = dive / "truth/cam0/fish";
    if (!fs::exists(masks)) return nullptr;
    double sum = 0.0;
    double num = 0.0;
    for (const auto& entry : fs::directory_iterator(masks)) {
        sum += cv::mean(cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE))[0] / 255.0;
        ++num;
    }
    return sum / std::max(1.0, num);
}

// Returns the cache key of the baseline: SIFT sees the images only, so the IMU is left out.
std::string images_key(const EnvelopeRun& run) {
    const DiveChange& change = run.step.change;
    std::string key = run.scene + "-" + std::to_string(run.seed);
    for (const std::string& word : run.step.rendered) key += word;
    for (const double value : {static_cast<double>(change.keep_every),
                               change.overlap,
                               change.dropped_share,
                               change.doubled_share,
                               change.gap_s,
                               change.blue_at_share,
                               change.blue_s,
                               change.calibration_error,
                               change.vertical_misalignment_px,
                               change.right_exposure})
        key += "-" + std::to_string(value);
    return file_name(key);
}

}  // namespace

std::string EnvelopeRun::name() const {
    return file_name("envelope-" + axis.name + "-" + step.label + "-" + scene + "-" +
                     std::to_string(seed));
}

EnvelopeRuns::EnvelopeRuns(fs::path program,
                           fs::path cache,
                           const fs::path& results,
                           EnvelopeScale scale)
    : program_(std::move(program)),
      cache_(std::move(cache)),
      kept_(made(results), program_),
      kept_sift_(made(cache_ / "sift"), "/proc/self/exe"),
      scale_(std::move(scale)) {}

json EnvelopeRuns::measured(const EnvelopeRun& run) {
    const std::string name = run.name() + "-" + size();
    const auto kept = kept_.find(name);
    if (kept && (!scale_.sift || kept->contains("sift"))) return *kept;
    const json result = measure(run);
    kept_.keep(name, result);
    return result;
}

std::string EnvelopeRuns::size() const {
    return file_name(std::to_string(scale_.width_px) + "px-" +
                     std::to_string(scale_.plain_length_m) + "-" + std::to_string(scale_.length_m));
}

json EnvelopeRuns::measure(const EnvelopeRun& run) {
    const TemporaryFolder folder;
    const DiveSources sources = sources_of(run);
    const fs::path dive = folder / "dive";
    write_changed(sources, run.step.change, static_cast<std::uint64_t>(run.seed), dive);
    json result = reconstructed(run, dive, folder / "out");
    result["axis"] = run.axis.name;
    result["step"] = run.step.label;
    result["scene"] = run.scene;
    result["seed"] = run.seed;
    const auto opened = dive::Dive::open(dive, folder / "scratch");
    result["path_m"] = path_length_m(opened->ground_truth());
    if (!run.step.rendered.empty()) result["moving_share"] = moving_share(sources.dive);
    if (scale_.sift) result["sift"] = sift(run, dive);
    return result;
}

DiveSources EnvelopeRuns::sources_of(const EnvelopeRun& run) const {
    const EnvelopeStep& step = run.step;
    DiveSources sources;
    const double length_m = step.length_m > 0.0 ? step.length_m : scale_.length_m;
    sources.dive = step.rendered.empty() ? rendered(run, scale_.plain_length_m, kPlainDive)
                                         : rendered(run, length_m, step.rendered);
    if (step.change.imu == DiveChange::Imu::OtherDive)
        sources.other = rendered(
            {run.axis, step, run.scene, run.seed + kOtherSeed}, scale_.plain_length_m, kPlainDive);
    if (step.change.blue_s > 0.0) sources.blue = rendered(run, scale_.plain_length_m, kBlueDive);
    return sources;
}

fs::path EnvelopeRuns::rendered(const EnvelopeRun& run,
                                double length_m,
                                const std::vector<std::string>& words) const {
    std::vector<std::string> command = {"simulate",
                                        "--scene",
                                        run.scene,
                                        "--seed",
                                        std::to_string(run.seed),
                                        "--length-m",
                                        std::to_string(length_m),
                                        "--width-px",
                                        std::to_string(scale_.width_px),
                                        "--height-px",
                                        std::to_string(scale_.height_px)};
    command.insert(command.end(), words.begin(), words.end());
    std::string name = "envelope";
    for (std::size_t i = 2; i < command.size(); ++i) name += "-" + command[i];
    const fs::path folder = cache_ / file_name(name);
    if (fs::exists(folder)) return folder;
    const fs::path unfinished = folder.string() + ".part";
    const fs::path log = folder.string() + ".log";
    fs::remove_all(unfinished);
    command.insert(command.begin(), program_.string());
    command.insert(command.end(), {"--out", unfinished.string()});
    if (run_program(command, log) != 0)
        throw std::runtime_error("not rendered: " + last_lines(log));
    fs::rename(unfinished, folder);
    return folder;
}

json EnvelopeRuns::reconstructed(const EnvelopeRun& run,
                                 const fs::path& dive,
                                 const fs::path& out) const {
    std::vector<std::string> command = {program_.string(),
                                        "reconstruct",
                                        dive.string(),
                                        "--out",
                                        out.string(),
                                        "--set",
                                        "surface=false"};
    for (const std::string& option : run.step.options)
        command.insert(command.end(), {"--set", option});
    const auto usage = run_measured(command, out.string() + ".log");
    std::ifstream stream(out / "metrics.json");
    const json metrics = stream ? json::parse(stream) : json::object();
    json result = tracked_run(metrics, usage.exit_code);
    result["cpu_s"] = usage.cpu_s;
    if (usage.exit_code != 0) result["said"] = last_lines(out.string() + ".log");
    return result;
}

json EnvelopeRuns::sift(const EnvelopeRun& run, const fs::path& dive) {
    const std::string key = images_key(run) + "-" + size();
    if (auto kept = kept_sift_.find(key)) return *kept;
    const TemporaryFolder scratch;
    const json result = sift_run(*dive::Dive::open(dive, scratch.path()));
    kept_sift_.keep(key, result);
    return result;
}

}  // namespace divemesh::bench
