CREATE TABLE sensors (
    number          INTEGER PRIMARY KEY,
    id              TEXT NOT NULL UNIQUE,
    project         TEXT NOT NULL,
    state           TEXT NOT NULL                             -- the last that was told as an event
                    CHECK (state IN ('online', 'idle', 'submerged', 'overdue', 'lost')),
    alarms          TEXT NOT NULL DEFAULT '[]',               -- JSON
    boot            INTEGER NOT NULL DEFAULT 0,               -- sensor_boots.number of what is told
    num_lives       INTEGER NOT NULL DEFAULT 0,               -- boots that spoke of now
    hello           TEXT NOT NULL DEFAULT '{}',               -- JSON
    status          TEXT NOT NULL DEFAULT '{}',               -- JSON, the newest of now
    status_at_ms    INTEGER NOT NULL DEFAULT 0,
    status_sequence INTEGER NOT NULL DEFAULT -1,
    seen_at_ms      INTEGER NOT NULL,
    back_at_ms      INTEGER NOT NULL DEFAULT 0,               -- 0: no dive announced
    twin_at_ms      INTEGER NOT NULL DEFAULT 0,               -- a boot that was superseded spoke
    created_at_ms   INTEGER NOT NULL
) STRICT;

CREATE INDEX sensors_by_age ON sensors (created_at_ms, id);

-- What came of each boot. `life`: the how-many-eth boot of its sensor to speak of now; the largest
-- speaks for the sensor. 0: all it ever sent was historical.
CREATE TABLE sensor_boots (
    sensor     INTEGER NOT NULL REFERENCES sensors (number),
    number     INTEGER NOT NULL,
    boot_id    TEXT NOT NULL,
    life       INTEGER NOT NULL DEFAULT 0,
    epoch_ms   INTEGER,                                       -- when its uptime was 0
    received   TEXT NOT NULL,                                 -- JSON, sequence ranges
    seen_at_ms INTEGER NOT NULL,
    PRIMARY KEY (sensor, number)
) STRICT;

CREATE UNIQUE INDEX sensor_boots_once ON sensor_boots (sensor, boot_id);

-- The history, one row a status, those of a sensor side by side: a day of one is one short scan.
-- The columns are kStatusFields of schemas/sensor_status.hpp.
CREATE TABLE sensor_statuses (
    sensor             INTEGER NOT NULL,
    time_ms            INTEGER NOT NULL,
    boot               INTEGER NOT NULL,
    sequence           INTEGER NOT NULL,
    recording          REAL,
    num_frames         REAL,
    num_dropped_frames REAL,
    frame_rate_hz      REAL,
    storage_free_bytes REAL,
    battery            REAL,
    depth_m            REAL,
    temperature_c      REAL,
    leak               REAL,
    humidity           REAL,
    imu_rate_hz        REAL,
    link_rssi_dbm      REAL,
    link_bytes_per_s   REAL,
    clock_offset_ms    REAL,
    more               TEXT NOT NULL,                         -- JSON, the rest as it came
    PRIMARY KEY (sensor, time_ms, boot, sequence)
) STRICT, WITHOUT ROWID;
