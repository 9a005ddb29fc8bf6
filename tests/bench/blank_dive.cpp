// Writes a copy of a dive folder in which the images of some seconds are blank, as in a cloud of
// silt: linked to the dive where the file system lets it, copied elsewhere.
//     divemesh_blank_dive DIVE OUT --from-s 30 --for-s 3

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
    fs::path dive;
    fs::path out;
    double from_s = 30.0;  // after the first image
    double for_s = 3.0;
};

void link_or_copy(const fs::path& from, const fs::path& to) {
    std::error_code failure;
    fs::create_hard_link(from, to, failure);
    if (failure) fs::copy_file(from, to);
}

// What is no camera's stays as it is.
void link_tree(const fs::path& from, const fs::path& to) {
    fs::create_directories(to);
    for (const auto& entry : fs::directory_iterator(from)) {
        const fs::path name = entry.path().filename();
        if (!entry.is_directory())
            link_or_copy(entry.path(), to / name);
        else if (!name.string().starts_with("cam"))
            link_tree(entry.path(), to / name);
    }
}

// One line of data.csv: "timestamp,file".
std::pair<std::int64_t, std::string> image_of(std::string line) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    const std::size_t comma = line.find(',');
    if (comma == std::string::npos) throw std::runtime_error("not a line of data.csv: " + line);
    return {std::stoll(line.substr(0, comma)), line.substr(line.find_first_not_of(", ", comma))};
}

int blank_camera(const fs::path& from, const fs::path& to, const Options& options) {
    fs::create_directories(to / "data");
    link_or_copy(from / "sensor.yaml", to / "sensor.yaml");
    std::ifstream lines(from / "data.csv");
    std::ofstream csv(to / "data.csv");
    std::int64_t first_ns = -1;
    int num_blank = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with('#')) {
            csv << line << "\n";
            continue;
        }
        auto [timestamp_ns, name] = image_of(line);
        if (first_ns < 0) first_ns = timestamp_ns;
        const double time_s = 1e-9 * static_cast<double>(timestamp_ns - first_ns);
        if (time_s >= options.from_s && time_s < options.from_s + options.for_s) {
            const cv::Mat seen = cv::imread((from / "data" / name).string());
            name = std::to_string(timestamp_ns) + "_blank.png";
            const cv::Mat blank(seen.size(), seen.type(), cv::mean(seen));
            if (!cv::imwrite((to / "data" / name).string(), blank))
                throw std::runtime_error("cannot write " + (to / "data" / name).string());
            ++num_blank;
        } else {
            link_or_copy(from / "data" / name, to / "data" / name);
        }
        csv << timestamp_ns << "," << name << "\n";
    }
    return num_blank;
}

int write_blank_dive(const Options& options) {
    const fs::path from = options.dive / "mav0";
    const fs::path to = options.out / "mav0";
    if (fs::exists(to)) throw std::runtime_error(to.string() + " is already there");
    link_tree(options.dive, options.out);
    int num_blank = 0;
    for (const std::string camera : {"cam0", "cam1"})
        num_blank += blank_camera(from / camera, to / camera, options);
    return num_blank;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) {
    using namespace divemesh;
    bench::Options options;
    CLI::App app{"Copies a dive and makes its images blank for some seconds."};
    app.add_option("dive", options.dive, "folder with mav0/")->required();
    app.add_option("out", options.out, "folder to write; created if missing")->required();
    app.add_option(
        "--from-s", options.from_s, "start of the blank images, s after the first image");
    app.add_option("--for-s", options.for_s, "length of the blank time, s");
    CLI11_PARSE(app, argc, argv);
    try {
        std::cout << bench::write_blank_dive(options) << " blank images\n";
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
    return 0;
}
