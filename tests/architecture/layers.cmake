# The layers, lowest first, for the scripts beside this file. A folder may include itself and the
# folders named for it. Nothing else.
get_filename_component(SOURCE_DIRECTORY ${SOURCE_DIRECTORY} ABSOLUTE BASE_DIR ${CMAKE_CURRENT_BINARY_DIR})

set(top_folders schemas storage worker api server sensor cli)
set(schemas_may_use "")
set(storage_may_use schemas)
set(worker_may_use schemas)
set(api_may_use schemas storage)
set(server_may_use schemas storage api)
set(sensor_may_use schemas worker api)
set(cli_may_use schemas storage worker api server sensor)

# Inside worker/ a folder includes only folders named before it.
set(worker_layers
  base stats types camera imu features stereo odometry optimisation keyframes loops calibration
  fusion mesh texture color mosaic io dive video recording markers boards simulator evaluation reef report board_calibration compare pipeline attempt runner)

# Of worker/, what the agent on the device may include: no solver library, no reader of tags.
set(sensor_may_use_of_worker base stats types camera features odometry dive)
