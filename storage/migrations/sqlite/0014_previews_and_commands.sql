ALTER TABLE sensors ADD COLUMN previews TEXT NOT NULL DEFAULT '{}';  -- JSON, the newest by camera

-- The newest pictures of each sensor. A number is never used again: clients keep what it named.
CREATE TABLE sensor_previews (
    number    INTEGER PRIMARY KEY AUTOINCREMENT,
    sensor    INTEGER NOT NULL REFERENCES sensors (number),
    time_ms   INTEGER NOT NULL,
    camera    TEXT NOT NULL,
    width     INTEGER NOT NULL,
    height    INTEGER NOT NULL,
    num_bytes INTEGER NOT NULL,
    sha256    TEXT NOT NULL,
    about     TEXT NOT NULL,                                  -- JSON, the rest as it came
    jpeg      BLOB NOT NULL
) STRICT;

CREATE INDEX sensor_previews_by_time ON sensor_previews (sensor, time_ms, number);

CREATE TABLE sensor_commands (
    number        INTEGER PRIMARY KEY AUTOINCREMENT,
    id            TEXT NOT NULL UNIQUE,
    sensor        INTEGER NOT NULL REFERENCES sensors (number),
    name          TEXT NOT NULL,
    arguments     TEXT NOT NULL,                              -- JSON
    state         TEXT NOT NULL
                  CHECK (state IN ('pending', 'sent', 'done', 'failed', 'refused', 'expired')),
    detail        TEXT NOT NULL DEFAULT '',
    requested_by  TEXT NOT NULL,
    created_at_ms INTEGER NOT NULL,
    expires_at_ms INTEGER NOT NULL,
    sent_at_ms    INTEGER NOT NULL DEFAULT 0,
    ended_at_ms   INTEGER NOT NULL DEFAULT 0
) STRICT;

CREATE INDEX sensor_commands_of_sensor ON sensor_commands (sensor, number);
CREATE INDEX sensor_commands_open ON sensor_commands (expires_at_ms)
    WHERE state IN ('pending', 'sent');
