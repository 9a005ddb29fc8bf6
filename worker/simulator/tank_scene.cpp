#include <array>
#include <numbers>

#include "worker/simulator/scene.hpp"
#include "worker/simulator/scene_parts.hpp"

// The tank scene: a room with a chair in the centre and boxes and drums around it. Frame of the
// place: floor at z = 0.
namespace divemesh::simulator {
namespace {

constexpr float kHalfPi = std::numbers::pi_v<float> / 2.0F;

void add_room(SceneBuilder& builder) {
    const float half_x_m = 3.4F;
    const float half_y_m = 3.0F;
    const float height_m = 2.8F;
    const auto flat = [](float, float) { return 0.0F; };
    builder.add("floor",
                Material::Carpet,
                make_height_field({-half_x_m, half_x_m, -half_y_m, half_y_m}, 0.03F, flat),
                place_at({0, 0, 0}));
    // A wall: x along it, y up, z into the room.
    const auto wall =
        [&](const std::string& name, float half_m, const Eigen::Vector3f& foot, float yaw) {
            builder.add(name,
                        Material::Brick,
                        make_height_field({-half_m, half_m, 0.0F, height_m}, 0.03F, flat),
                        place_at(foot, yaw) * place_at({0, 0, 0}, 0.0F, 0.0F, kHalfPi));
        };
    wall("wall_north", half_x_m, {0.0F, half_y_m, 0.0F}, 0.0F);
    wall("wall_south", half_x_m, {0.0F, -half_y_m, 0.0F}, 2.0F * kHalfPi);
    wall("wall_east", half_y_m, {half_x_m, 0.0F, 0.0F}, -kHalfPi);
    wall("wall_west", half_y_m, {-half_x_m, 0.0F, 0.0F}, kHalfPi);
}

void add_chair(SceneBuilder& builder, float yaw) {
    const auto chair = place_at({0, 0, 0}, yaw);
    Shape shape;
    const auto part = [&](const Eigen::Vector3f& size_m, const Eigen::Vector3f& middle) {
        Shape box = make_box(size_m, 0.02F);
        for (Eigen::Vector3f& p : box.vertices) p += middle;
        append(shape, box);
    };
    part({0.44F, 0.44F, 0.04F}, {0.0F, 0.0F, 0.46F});
    for (const float x : {-0.19F, 0.19F}) {
        part({0.045F, 0.045F, 0.44F}, {x, 0.19F, 0.22F});
        part({0.045F, 0.045F, 0.92F}, {x, -0.19F, 0.46F});
        part({0.03F, 0.335F, 0.04F}, {x, 0.0F, 0.17F});
    }
    for (const float z : {0.62F, 0.74F, 0.86F}) part({0.335F, 0.02F, 0.07F}, {0.0F, -0.19F, z});
    builder.add("chair", Material::Wood, shape, chair);
    const auto at = [&](float x, float y, float z) -> Eigen::Vector3d {
        return (chair * Eigen::Vector3f(x, y, z)).cast<double>();
    };
    builder.add_distance("seat_width",
                         "front top corners of the seat",
                         at(-0.22F, 0.22F, 0.48F),
                         at(0.22F, 0.22F, 0.48F));
    builder.add_distance("seat_depth",
                         "top corners of the seat, one side",
                         at(0.22F, -0.22F, 0.48F),
                         at(0.22F, 0.22F, 0.48F));
    builder.add_distance("back_height",
                         "outer back edge of a back post",
                         at(0.2125F, -0.2125F, 0.0F),
                         at(0.2125F, -0.2125F, 0.92F));
    builder.add_distance("back_width",
                         "outer top corners of the back posts",
                         at(-0.2125F, -0.2125F, 0.92F),
                         at(0.2125F, -0.2125F, 0.92F));
}

void add_drum(SceneBuilder& builder,
              const std::string& name,
              float radius_m,
              float height_m,
              const Eigen::Vector3f& at) {
    builder.add(name, Material::Drum, make_cylinder(radius_m, height_m, 0.02F), place_at(at));
    const Eigen::Vector3d top = at.cast<double>() + Eigen::Vector3d(0, 0, height_m);
    builder.add_distance(name + "_diameter",
                         "across the top rim, along x",
                         top - Eigen::Vector3d(radius_m, 0, 0),
                         top + Eigen::Vector3d(radius_m, 0, 0));
}

}  // namespace

Scene make_tank_scene(std::uint64_t seed, int year) {
    base::RandomRow random(base::hash64(seed, 0x74616e6bULL));
    const float yaw = draw(random, -0.6, 0.6);
    SceneBuilder builder(seed, year, place_at({0.0F, 0.0F, 0.0F}, draw(random, -0.2, 0.2)));
    add_room(builder);
    add_chair(builder, yaw);
    struct Box {
        Eigen::Vector3f size_m;
        Eigen::Vector3f foot;
        float yaw;
    };
    const std::array<Box, 7> boxes = {{{{0.4F, 0.3F, 0.26F}, {0.75F, 0.35F, 0.0F}, 0.4F},
                                       {{0.3F, 0.25F, 0.2F}, {0.72F, 0.36F, 0.26F}, 0.9F},
                                       {{0.5F, 0.36F, 0.34F}, {-0.75F, 0.5F, 0.0F}, -0.3F},
                                       {{0.34F, 0.26F, 0.22F}, {-0.78F, 0.5F, 0.34F}, 0.2F},
                                       {{0.36F, 0.36F, 0.3F}, {0.3F, -0.85F, 0.0F}, 0.15F},
                                       {{0.45F, 0.3F, 0.4F}, {-0.7F, -0.7F, 0.0F}, 0.8F},
                                       {{0.14F, 0.12F, 0.12F}, {0.03F, 0.02F, 0.48F}, 0.5F}}};
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const Eigen::Vector3f jitter(draw(random, -0.06, 0.06), draw(random, -0.06, 0.06), 0.0F);
        const bool stacked = boxes[i].foot.z() > 0.0F;
        add_measured_box(builder,
                         "box_" + std::to_string(i),
                         Material::Cardboard,
                         boxes[i].size_m,
                         place_at(boxes[i].foot + (stacked ? Eigen::Vector3f::Zero()
                                                           : Eigen::Vector3f(0.4F * jitter)),
                                  boxes[i].yaw));
    }
    add_drum(builder, "drum_0", 0.15F, 0.45F, {0.15F, 0.95F, 0.0F});
    add_drum(builder, "drum_1", 0.11F, 0.3F, {-0.2F, -1.2F, 0.0F});
    add_drum(builder, "drum_2", 0.18F, 0.3F, {1.15F, -0.3F, 0.0F});
    add_scale_bar(builder, "scale_bar", 0.8F, place_at({-1.2F, 0.0F, 0.0F}, 1.3F));
    const Shape parcel = make_box({0.24F, 0.2F, 0.18F}, 0.02F);
    builder.add_changing("parcel_0",
                         Material::Cardboard,
                         parcel,
                         place_at({1.0F, 0.9F, 0.09F}, 0.3F),
                         SceneBuilder::Fate::Lost);
    builder.add_changing("parcel_1",
                         Material::Cardboard,
                         parcel,
                         place_at({-1.1F, -0.3F, 0.09F}, 0.9F),
                         SceneBuilder::Fate::New);
    SurveyPath path;
    path.center_world = {0.0, 0.0, 1.15};
    path.semi_axis_x_m = 1.95;
    path.semi_axis_y_m = 1.8;
    path.start_angle = draw(random, -1.2, -0.8);
    path.look_yaw = std::numbers::pi / 2.0;
    path.look_pitch = 0.4;
    path.speed_m_s = 0.22;
    path.max_scale = 1.15;
    return builder.finish(path, 0.0);
}

}  // namespace divemesh::simulator
