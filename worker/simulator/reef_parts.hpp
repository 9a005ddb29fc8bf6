#pragma once

#include "worker/base/hashed_random.hpp"
#include "worker/simulator/noise_field.hpp"
#include "worker/simulator/scene.hpp"

// What a reef is made of: spurs of coral rock, sand between them, and what grows on both. Heights
// in m in the frame of the place, about 0; what is higher at a point covers the other.
namespace divemesh::simulator {

float reef_rock_height(const NoiseField& noise, float x, float y);
float reef_sand_height(const NoiseField& noise, float x, float y);
float reef_height(const NoiseField& noise, float x, float y);  // of the higher one

// "coral_<number>" where reef_height() is the ground: a head, a table, a bush or a sponge by its
// number. Every fifth changes over the years.
void add_coral(SceneBuilder& builder, base::RandomRow& random, int number, float x, float y);

}  // namespace divemesh::simulator
