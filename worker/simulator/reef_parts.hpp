#pragma once

#include "worker/base/hashed_random.hpp"
#include "worker/simulator/noise_field.hpp"
#include "worker/simulator/scene.hpp"

// The parts of a reef: spurs of coral rock, sand between them, and what grows on both. Heights are
// in m in the frame of the place, about 0; the higher of rock and sand is the ground.
namespace divemesh::simulator {

float reef_rock_height(const NoiseField& noise, float x, float y);
float reef_sand_height(const NoiseField& noise, float x, float y);
float reef_height(const NoiseField& noise, float x, float y);  // of the higher one

// Adds "coral_<number>" on the ground of reef_height(): a head, a table, a bush or a sponge by its
// number. Every fifth one changes over the years.
void add_coral(SceneBuilder& builder, base::RandomRow& random, int number, float x, float y);

}  // namespace divemesh::simulator
