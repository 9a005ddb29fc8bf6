#include "worker/evaluation/evaluate.hpp"

#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/metrics_table.hpp"

namespace divemesh::cli {
namespace {

int print(const nlohmann::json& metrics, const Context& context) {
    std::cout << (context.json ? metrics.dump(2) + "\n" : metrics_table(metrics));
    return kExitDone;
}

void add_trajectory(CLI::App& parent, Context& context) {
    struct Options {
        std::filesystem::path estimate;
        std::filesystem::path reference;
        evaluation::TrajectoryEvaluationOptions how;
        std::string pairs = "consecutive";
        std::string lever_arm;
        std::string time_offset;
    };
    auto* command =
        parent.add_subcommand("trajectory", "error of a trajectory against ground truth");
    auto options = std::make_shared<Options>();
    command
        ->add_option("--estimate", options->estimate, "trajectory to evaluate: TUM, EuRoC or KITTI")
        ->required();
    command->add_option("--reference", options->reference, "true trajectory: TUM, EuRoC or KITTI")
        ->required();
    command
        ->add_option("--rpe-delta-m",
                     options->how.relative.delta_m,
                     "path length of the relative pose error, m")
        ->check(CLI::Range(1e-3, 1e6))
        ->capture_default_str();
    command
        ->add_option("--rpe-pairs", options->pairs, "pairs of poses, as in evo: consecutive or all")
        ->check(CLI::IsMember({"consecutive", "all"}))
        ->capture_default_str();
    command->add_option("--lever-arm",
                        options->lever_arm,
                        "pose of the tracked marker: x,y,z[,qw,qx,qy,qz] in m, or solve");
    command->add_option(
        "--time-offset", options->time_offset, "the truth's clock minus ours, s, or solve");
    command->callback([options, &context] {
        context.command = [options, &context] {
            auto how = options->how;
            if (options->pairs == "all")
                how.relative.pairs = evaluation::RelativePoseOptions::Pairs::All;
            if (!options->lever_arm.empty()) set_lever_arm(how.truth, options->lever_arm);
            if (!options->time_offset.empty()) set_time_offset(how.truth, options->time_offset);
            return print(
                evaluation::evaluate_trajectory(options->estimate, options->reference, how),
                context);
        };
    });
}

void add_mesh(CLI::App& parent, Context& context) {
    auto* command = parent.add_subcommand("mesh", "distance of a mesh from a reference mesh");
    struct Options {
        evaluation::MeshEvaluationRequest request;
        std::filesystem::path estimate_trajectory;
        std::filesystem::path reference_trajectory;
        std::filesystem::path scene;
    };
    auto options = std::make_shared<Options>();
    command
        ->add_option("--estimate", options->request.estimate, "mesh to evaluate: PLY, OBJ or GLB")
        ->required();
    command
        ->add_option("--reference", options->request.reference, "reference mesh: PLY, OBJ or GLB")
        ->required();
    auto* ours =
        command->add_option("--estimate-trajectory",
                            options->estimate_trajectory,
                            "trajectory of the mesh, to align it with --reference-trajectory");
    command
        ->add_option("--reference-trajectory",
                     options->reference_trajectory,
                     "true trajectory in the reference's frame")
        ->needs(ours);
    ours->needs("--reference-trajectory");
    command->add_option("--scene",
                        options->scene,
                        "all true surface that a camera saw (simulate writes scene.ply): the "
                        "estimate is compared with it, the reference with the estimate");
    command->callback([options, &context] {
        context.command = [options, &context] {
            if (!options->estimate_trajectory.empty()) {
                options->request.estimate_trajectory = options->estimate_trajectory;
                options->request.reference_trajectory = options->reference_trajectory;
            }
            if (!options->scene.empty()) options->request.scene = options->scene;
            return print(evaluation::evaluate_mesh(options->request), context);
        };
    });
}

}  // namespace

void add_evaluate(CLI::App& app, Context& context) {
    auto* command =
        app.add_subcommand("evaluate", "compare a trajectory or mesh with ground truth");
    command->require_subcommand(1);
    add_trajectory(*command, context);
    add_mesh(*command, context);
}

}  // namespace divemesh::cli
