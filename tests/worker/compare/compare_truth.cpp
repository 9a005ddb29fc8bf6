#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>

#include "tests/synthetic/true_change.hpp"
#include "worker/compare/compare.hpp"

// Compares two reconstructions of simulated dives and prints the truth beside the metrics.
namespace divemesh {
namespace {

using nlohmann::json;

void print(const std::string& name, const json& interval, double truth) {
    const double low = interval.at("low");
    const double high = interval.at("high");
    std::printf("%-10s %8.3f l (%.3f to %.3f), true %8.3f l: %s\n",
                name.c_str(),
                1e3 * interval.at("value").get<double>(),
                1e3 * low,
                1e3 * high,
                1e3 * truth,
                low <= truth && truth <= high ? "within" : "OUTSIDE");
}

Eigen::AlignedBox2d box_of(const json& patch, double margin_m) {
    const auto corner = [&](const char* name) {
        const json& xy = patch.at("box").at(name);
        return Eigen::Vector2d(xy.at(0).get<double>(), xy.at(1).get<double>());
    };
    return {corner("min") - Eigen::Vector2d::Constant(margin_m),
            corner("max") + Eigen::Vector2d::Constant(margin_m)};
}

void judge(const json& document, const synthetic::TrueChange& truth) {
    const auto all = truth.all();
    std::printf(
        "registration by %s: agreement %.3f, residual %.2f mm, 95 %%: x %.2f y %.2f z %.2f mm\n",
        document["registration"]["method"].get<std::string>().c_str(),
        document["registration"]["agreement"].get<double>(),
        1e3 * document["registration"]["residual_rms_m"].get<double>(),
        1e3 * document["registration"]["uncertainty95"]["x_m"].get<double>(),
        1e3 * document["registration"]["uncertainty95"]["y_m"].get<double>(),
        1e3 * document["registration"]["uncertainty95"]["z_m"].get<double>());
    std::printf(
        "ground both %.2f, hidden %.2f m2; LoD95 %.1f mm (factor %.2f); rest beyond %.2f %%\n",
        document["ground"]["both_m2"].get<double>(),
        document["ground"]["hidden_m2"].get<double>(),
        1e3 * document["distances"]["median_lod95_m"].get<double>(),
        document["distances"]["level_factor"].get<double>(),
        100.0 * document["rest"]["beyond_share"].get<double>());
    print("grown", document.at("grown").at("volume_m3"), all.grown_m3);
    print("lost", document.at("lost").at("volume_m3"), all.lost_m3);
    for (const json& patch : document.at("patches")) {
        const auto there =
            truth.in(box_of(patch, document.at("options").at("cylinder_m").get<double>()));
        const bool grown = patch.at("kind") == "grown";
        print((grown ? "+" : "-") + std::to_string(patch.at("number").get<int>()),
              patch.at("volume_m3"),
              grown ? there.grown_m3 : there.lost_m3);
    }
}

int run(int argc, char** argv) {
    CLI::App app("Judges a comparison of simulated dives by the scene's own geometry.");
    std::string scene = "reef";
    std::uint64_t seed = 1;
    int year = 2;
    double length_m = 6.0;
    std::filesystem::path truth;
    compare::CompareRequest request;
    app.add_option("a", request.a, "earlier reconstruction")->required();
    app.add_option("b", request.b, "later reconstruction")->required();
    app.add_option("dive", truth, "folder of the earlier dive")->required();
    app.add_option("--out", request.out, "folder of the comparison")->required();
    app.add_option("--scene", scene);
    app.add_option("--seed", seed);
    app.add_option("--length-m", length_m, "of the path");
    app.add_option("--year", year, "of the later dive");
    app.add_option("--threads", request.num_threads);
    CLI11_PARSE(app, argc, argv);
    const json document = compare::compare_reconstructions(request);
    const auto kind = simulator::scene_kind_from_string(scene);
    judge(document,
          synthetic::TrueChange(simulator::make_scene(kind, seed, 1, length_m),
                                simulator::make_scene(kind, seed, year, length_m),
                                request.a,
                                truth / "mav0/state_groundtruth_estimate0/data.csv",
                                request.out));
    return 0;
}

}  // namespace
}  // namespace divemesh

int main(int argc, char** argv) try {
    return divemesh::run(argc, argv);
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
