#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "worker/pipeline/map_metrics.hpp"
#include "worker/pipeline/surface.hpp"
#include "worker/pipeline/texture_metrics.hpp"
#include "worker/pipeline/water_color.hpp"
#include "worker/types/optimised_track.hpp"
#include "worker/types/rig_alignment.hpp"
#include "worker/types/track.hpp"

namespace divemesh::pipeline {

// Saves and loads the results of stages. A file contains the key of its inputs (content of the
// dive, options, version). load returns nullopt if the file is missing, cut short or has another
// key; the stage then runs again. Files are written to a temporary name and renamed. save throws
// Error{OutOfSpace}.
void save_rig_alignment(const std::filesystem::path& file,
                        const std::string& key,
                        const types::RigAlignment& alignment);
std::optional<types::RigAlignment> load_rig_alignment(const std::filesystem::path& file,
                                                      const std::string& key);

void save_track(const std::filesystem::path& file,
                const std::string& key,
                const types::Track& track);
std::optional<types::Track> load_track(const std::filesystem::path& file, const std::string& key);

void save_optimised_track(const std::filesystem::path& file,
                          const std::string& key,
                          const types::OptimisedTrack& track);
std::optional<types::OptimisedTrack> load_optimised_track(const std::filesystem::path& file,
                                                          const std::string& key);

void save_cloud_metrics(const std::filesystem::path& file,
                        const std::string& key,
                        const CloudMetrics& metrics);
std::optional<CloudMetrics> load_cloud_metrics(const std::filesystem::path& file,
                                               const std::string& key);

void save_surface(const std::filesystem::path& file,
                  const std::string& key,
                  const Surface& surface);
std::optional<Surface> load_surface(const std::filesystem::path& file, const std::string& key);

void save_water_color(const std::filesystem::path& file,
                      const std::string& key,
                      const WaterColor& color);
std::optional<WaterColor> load_water_color(const std::filesystem::path& file,
                                           const std::string& key);

void save_texture_metrics(const std::filesystem::path& file,
                          const std::string& key,
                          const TextureMetrics& metrics);
std::optional<TextureMetrics> load_texture_metrics(const std::filesystem::path& file,
                                                   const std::string& key);

}  // namespace divemesh::pipeline
