#include "tests/bench/simulated_dives.hpp"

#include <Eigen/Core>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <stdexcept>

#include "tests/bench/program.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/known_distances.hpp"
#include "worker/evaluation/surface_index.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json marks_of(const Eigen::Vector3d& p_world, const evaluation::MarkingInput& input) {
    json marks = json::array();
    for (const dive::Mark& mark : evaluation::mark_point(p_world, input)) {
        marks.push_back({{"timestamp_ns", mark.timestamp_ns},
                         {"left", {mark.pixel_left.x(), mark.pixel_left.y()}}});
        if (mark.pixel_right)
            marks.back()["right"] = {mark.pixel_right->x(), mark.pixel_right->y()};
    }
    return marks;
}

// The ends of the known distances, marked in every fifth frame as the true rig saw them.
json marked_distances(const dive::Dive& dive) {
    const auto reference = dive.read_reference_mesh();
    if (!reference) return json::array();
    std::vector<std::int64_t> timestamps_ns;
    for (std::size_t i = 0; i < dive.ground_truth().size(); i += 5)
        timestamps_ns.push_back(dive.ground_truth()[i].timestamp_ns);
    const evaluation::SurfaceIndex surface(*reference);
    const evaluation::MarkingInput input{dive.rig(), dive.ground_truth(), timestamps_ns, surface};
    json distances = json::array();
    for (const dive::KnownDistance& known : dive.known_distances())
        distances.push_back({{"name", known.name},
                             {"distance_m", known.distance_m},
                             {"marks_a", marks_of(known.a_world, input)},
                             {"marks_b", marks_of(known.b_world, input)}});
    return distances;
}

// cam1's place on the body, in the text of its sensor.yaml.
std::string with_place(const std::string& yaml, const Eigen::Vector3d& place) {
    const std::size_t begin = yaml.find('[', yaml.find("T_BS")) + 1;
    const std::size_t end = yaml.find(']', begin);
    std::istringstream items(yaml.substr(begin, end - begin));
    std::ostringstream list;
    list << std::setprecision(15);
    std::string item;
    for (int i = 0; std::getline(items, item, ','); ++i) {
        if (i > 0) list << ", ";
        if (i < 12 && i % 4 == 3)
            list << place[i / 4];
        else
            list << std::stod(item);
    }
    return yaml.substr(0, begin) + list.str() + yaml.substr(end);
}

void write_with_baseline_error(const fs::path& dive, double error, const fs::path& copy) {
    fs::remove_all(copy);
    fs::copy(dive, copy, fs::copy_options::recursive | fs::copy_options::create_hard_links);
    const TemporaryFolder scratch;
    const auto exact = dive::Dive::open(dive, scratch.path());
    const Eigen::Vector3d left = exact->rig().T_imu_cam0.translation();
    const Eigen::Vector3d right = exact->rig().T_imu_cam1.translation();
    const fs::path yaml = copy / "mav0" / "cam1" / "sensor.yaml";
    std::stringstream text;
    text << std::ifstream(yaml).rdbuf();
    const std::string altered = with_place(text.str(), left + (1.0 + error) * (right - left));
    const fs::path measurements = copy / "measurements.json";
    for (const fs::path& file : {yaml, measurements}) fs::remove(file);  // not the link's other end
    std::ofstream(yaml) << altered;
    std::ofstream(measurements) << json{{"distances", marked_distances(*exact)}}.dump();
}

}  // namespace

std::string SimulatedDive::name() const {
    return (num_laps > 0 ? "laps" : scene) + "-" + std::to_string(seed);
}

double SimulatedDive::baseline_error() const {
    const std::string words = scene + " " + name();
    std::seed_seq seeds(words.begin(), words.end());
    std::mt19937_64 random(seeds);
    return types::kCalibrationSigma * std::normal_distribution<double>()(random);
}

std::vector<SimulatedDive> dives_of_seed(int seed) {
    const char* scenes[] = {"tank", "barge", "reef"};
    std::vector<SimulatedDive> dives;
    for (const char* scene : scenes) dives.push_back({scene, seed});
    dives.push_back({scenes[seed % 3], seed, 2});
    return dives;
}

void reconstruct_surface(const fs::path& program, const fs::path& dive, const fs::path& out) {
    const fs::path log = out.string() + ".log";
    if (run_program(
            {program.string(), "reconstruct", dive.string(), "--out", out.string(), "--no-texture"},
            log) != 0)
        throw std::runtime_error(out.filename().string() + ": " + last_lines(log));
}

fs::path SimulatedDives::rendered(const SimulatedDive& dive) const {
    const fs::path folder = cache / ("bounds-" + dive.name());
    if (fs::exists(folder)) return folder;
    const fs::path unfinished = folder.string() + ".part";
    fs::create_directories(cache);
    fs::remove_all(unfinished);
    std::vector<std::string> words = {program.string(), "simulate", "--scene", dive.scene};
    for (const auto& [flag, value] : {std::pair<std::string, std::string>{"--length-m", "3"},
                                      {"--rate", "10"},
                                      {"--width-px", "400"},
                                      {"--height-px", "300"}})
        words.insert(words.end(), {flag, value});
    words.insert(words.end(), {"--seed", std::to_string(dive.seed), "--out", unfinished.string()});
    if (dive.scene != "tank") words.insert(words.end(), {"--water", "green"});
    if (dive.num_laps > 0) words.insert(words.end(), {"--laps", std::to_string(dive.num_laps)});
    const fs::path log = folder.string() + ".log";
    if (run_program(words, log) != 0) throw std::runtime_error("not rendered: " + last_lines(log));
    fs::rename(unfinished, folder);
    return folder;
}

void SimulatedDives::reconstruct(const SimulatedDive& dive, const fs::path& out) const {
    const fs::path copy = out.string() + "-dive";
    write_with_baseline_error(rendered(dive), dive.baseline_error(), copy);
    reconstruct_surface(program, copy, out);
    fs::remove_all(copy);
}

}  // namespace divemesh::bench
