-- Truth that comes after its dive, figures as data, reports by the clock.
ALTER TABLE dives ADD COLUMN rig TEXT NOT NULL DEFAULT '';
ALTER TABLE uploads ADD COLUMN truth_id TEXT NOT NULL DEFAULT '';     -- '': it became none
ALTER TABLE jobs ADD COLUMN requirements TEXT NOT NULL DEFAULT '[]';  -- JSON, of a success

CREATE TABLE truth_files (
    id            TEXT PRIMARY KEY,
    project       TEXT NOT NULL,
    dive_id       TEXT NOT NULL REFERENCES dives (id),
    kind          TEXT NOT NULL
                  CHECK (kind IN ('ground_truth', 'reference', 'measurements', 'areas')),
    name          TEXT NOT NULL,
    sha256        TEXT NOT NULL,
    size_bytes    INTEGER NOT NULL CHECK (size_bytes >= 0),
    blob          TEXT NOT NULL UNIQUE,
    created_at_ms INTEGER NOT NULL,
    deleted_at_ms INTEGER NOT NULL DEFAULT 0                  -- > 0: its blob is still to go
) STRICT;

CREATE UNIQUE INDEX truth_files_once ON truth_files (dive_id, kind, sha256)
    WHERE deleted_at_ms = 0;
CREATE INDEX truth_files_of_dive ON truth_files (dive_id, created_at_ms, id);
CREATE INDEX truth_files_of_project ON truth_files (project, size_bytes);
CREATE INDEX truth_files_to_remove ON truth_files (deleted_at_ms) WHERE deleted_at_ms > 0;

CREATE TRIGGER truth_files_stay BEFORE UPDATE OF dive_id, kind, name, sha256, size_bytes, blob
ON truth_files
BEGIN
    SELECT RAISE(ABORT, 'a file of truth never changes');
END;

CREATE TABLE figure_names (
    number INTEGER PRIMARY KEY,
    name   TEXT NOT NULL UNIQUE,
    unit   TEXT NOT NULL,
    method TEXT NOT NULL
) STRICT;

-- What was measured at one time: the job that measured, and what its dive and reconstruction were.
-- Numbers rise with time and are never used again, so they are the order of every series.
CREATE TABLE figure_sets (
    number             INTEGER PRIMARY KEY AUTOINCREMENT,
    job_id             TEXT NOT NULL UNIQUE REFERENCES jobs (id),
    measured_job_id    TEXT NOT NULL,                         -- the reconstruction
    project            TEXT NOT NULL,
    dive_id            TEXT NOT NULL REFERENCES dives (id),
    kind               TEXT NOT NULL,
    site               TEXT NOT NULL,
    rig                TEXT NOT NULL,
    preset             TEXT NOT NULL,
    version            TEXT NOT NULL,
    calibration_sha256 TEXT NOT NULL,
    time_ms            INTEGER NOT NULL
) STRICT;

CREATE INDEX figure_sets_of_dive ON figure_sets (dive_id);
CREATE INDEX figure_sets_of_site ON figure_sets (site, project);
CREATE INDEX figure_sets_of_rig ON figure_sets (rig, project);
CREATE INDEX figure_sets_of_measured_job ON figure_sets (measured_job_id);
CREATE INDEX figure_sets_by_time ON figure_sets (time_ms);

-- The values of one figure lie side by side, oldest first: a series is one scan.
CREATE TABLE figures (
    figure     INTEGER NOT NULL REFERENCES figure_names (number),
    set_number INTEGER NOT NULL REFERENCES figure_sets (number),
    value      REAL NOT NULL,
    PRIMARY KEY (figure, set_number)
) STRICT, WITHOUT ROWID;

CREATE TABLE schedules (
    id            TEXT PRIMARY KEY,
    project       TEXT NOT NULL,
    cron          TEXT NOT NULL,
    tag           TEXT NOT NULL,
    preset        TEXT NOT NULL,
    options       TEXT NOT NULL,                              -- JSON, of the reports
    created_at_ms INTEGER NOT NULL,
    next_run_ms   INTEGER NOT NULL,
    last_run_ms   INTEGER NOT NULL DEFAULT 0,
    last_num_jobs INTEGER NOT NULL DEFAULT 0,
    last_problem  TEXT NOT NULL DEFAULT ''
) STRICT;

CREATE INDEX schedules_due ON schedules (next_run_ms);
