-- What a queue needs beyond a list: order, limits, pauses, retries by class, workers, forecasts.

ALTER TABLE jobs ADD COLUMN parents TEXT NOT NULL DEFAULT '[]';            -- JSON, as in job_parents
ALTER TABLE jobs ADD COLUMN paused INTEGER NOT NULL DEFAULT 0 CHECK (paused IN (0, 1));
ALTER TABLE jobs ADD COLUMN lowered INTEGER NOT NULL DEFAULT 0 CHECK (lowered IN (0, 1));
ALTER TABLE jobs ADD COLUMN stages TEXT NOT NULL DEFAULT '[]';             -- JSON, of the newest attempt
ALTER TABLE jobs ADD COLUMN failure_remedy TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN unique_key TEXT NOT NULL DEFAULT '';           -- kind, preset, options
ALTER TABLE jobs ADD COLUMN queue_rank_ms INTEGER NOT NULL DEFAULT 0;      -- the least is first
ALTER TABLE jobs ADD COLUMN lease_ms INTEGER NOT NULL DEFAULT 0;           -- how long it was given for
ALTER TABLE jobs ADD COLUMN lease_renewed INTEGER NOT NULL DEFAULT 0 CHECK (lease_renewed IN (0, 1));
ALTER TABLE jobs ADD COLUMN num_silent_losses INTEGER NOT NULL DEFAULT 0;  -- in a row, never renewed
ALTER TABLE attempts ADD COLUMN failure_remedy TEXT NOT NULL DEFAULT '';

UPDATE jobs SET unique_key = id, queue_rank_ms = created_at_ms - 600000 * priority;
UPDATE jobs SET parents = (SELECT '["' || parent_id || '"]' FROM job_parents WHERE job_id = jobs.id)
    WHERE id IN (SELECT job_id FROM job_parents);

DROP INDEX jobs_due;
CREATE INDEX jobs_due ON jobs (queue_rank_ms, id, project, kind, not_before_ms)
    WHERE state = 'queued';

-- The same work is not asked for twice while it is still to be done.
CREATE UNIQUE INDEX jobs_once ON jobs (dive_id, unique_key)
    WHERE state IN ('held', 'queued', 'running');

-- Parents are named when a job is made, before it can have children: so there are no cycles.
CREATE TRIGGER job_parents_come_first BEFORE INSERT ON job_parents
WHEN NEW.job_id = NEW.parent_id
    OR EXISTS (SELECT 1 FROM job_parents WHERE parent_id = NEW.job_id)
BEGIN
    SELECT RAISE(ABORT, 'a job cannot wait for one that waits for it');
END;

CREATE TRIGGER job_parents_stay BEFORE UPDATE ON job_parents
BEGIN
    SELECT RAISE(ABORT, 'the parents of a job do not change');
END;

-- Project '' is the whole queue; a project without a row is neither paused nor limited.
CREATE TABLE queues (
    project     TEXT PRIMARY KEY,
    paused      INTEGER NOT NULL DEFAULT 0 CHECK (paused IN (0, 1)),
    max_running INTEGER NOT NULL DEFAULT 0 CHECK (max_running >= 0) -- 0: no limit
) STRICT;

CREATE TABLE workers (
    name          TEXT PRIMARY KEY,
    num_slots     INTEGER NOT NULL CHECK (num_slots >= 1),
    draining      INTEGER NOT NULL DEFAULT 0 CHECK (draining IN (0, 1)),
    started_at_ms INTEGER NOT NULL,
    seen_at_ms    INTEGER NOT NULL
) STRICT;

-- Measured; a unit is a frame, for an intake a byte of the archive. Newer jobs weigh more.
CREATE TABLE job_speeds (
    kind             TEXT NOT NULL,
    preset           TEXT NOT NULL,
    seconds_per_unit REAL NOT NULL,
    PRIMARY KEY (kind, preset)
) STRICT;
