-- Times are unix milliseconds of the catalog's clock. Ids are made by us, never by a client.

CREATE TABLE dives (
    id             TEXT PRIMARY KEY,
    project        TEXT NOT NULL,
    state          TEXT NOT NULL DEFAULT 'checking'
                   CHECK (state IN ('checking', 'ready', 'refused')),
    name           TEXT NOT NULL,
    site           TEXT NOT NULL DEFAULT '',
    tags           TEXT NOT NULL DEFAULT '[]',                -- JSON
    archive_sha256 TEXT NOT NULL,
    content_sha256 TEXT NOT NULL DEFAULT '',
    archive_bytes  INTEGER NOT NULL CHECK (archive_bytes >= 0),
    blob           TEXT NOT NULL,
    num_frames     INTEGER NOT NULL DEFAULT 0,
    duration_s     REAL NOT NULL DEFAULT 0,
    findings       TEXT NOT NULL DEFAULT '[]',                -- JSON
    thumbnail_blob TEXT NOT NULL DEFAULT '',
    created_at_ms  INTEGER NOT NULL
) STRICT;

CREATE INDEX dives_by_age ON dives (created_at_ms, id);

-- One recording is one dive of a project, whoever comes first; a refused one stands in nobody's way.
CREATE UNIQUE INDEX dives_content_once ON dives (project, content_sha256)
    WHERE content_sha256 <> '' AND state <> 'refused';
CREATE UNIQUE INDEX dives_archive_once ON dives (project, archive_sha256)
    WHERE archive_sha256 <> '' AND state <> 'refused';

CREATE TRIGGER dives_are_judged_once BEFORE UPDATE OF state ON dives
WHEN OLD.state <> 'checking' OR NEW.state = 'checking'
BEGIN
    SELECT RAISE(ABORT, 'forbidden dive transition');
END;

CREATE TABLE uploads (
    id            TEXT PRIMARY KEY,
    project       TEXT NOT NULL,
    length_bytes  INTEGER NOT NULL CHECK (length_bytes >= 0),
    offset_bytes  INTEGER NOT NULL DEFAULT 0 CHECK (offset_bytes BETWEEN 0 AND length_bytes),
    metadata      TEXT NOT NULL,
    blob          TEXT NOT NULL UNIQUE,
    dive_id       TEXT REFERENCES dives (id),                 -- null until it became one
    created_at_ms INTEGER NOT NULL,
    touched_at_ms INTEGER NOT NULL                            -- created or advanced
) STRICT;

CREATE INDEX uploads_by_touch ON uploads (touched_at_ms) WHERE dive_id IS NULL;

CREATE TABLE jobs (
    id                  TEXT PRIMARY KEY,
    project             TEXT NOT NULL,
    dive_id             TEXT NOT NULL REFERENCES dives (id),
    kind                TEXT NOT NULL
                        CHECK (kind IN ('intake', 'reconstruct', 'accuracy_report', 'compare')),
    state               TEXT NOT NULL
                        CHECK (state IN ('held', 'queued', 'running', 'succeeded', 'failed', 'dead',
                                         'cancelled')),
    preset              TEXT NOT NULL DEFAULT '',
    options             TEXT NOT NULL DEFAULT '{}',           -- JSON
    priority            INTEGER NOT NULL DEFAULT 0,
    num_attempts        INTEGER NOT NULL DEFAULT 0,           -- that count towards the maximum
    max_attempts        INTEGER NOT NULL CHECK (max_attempts >= 1),
    attempt             INTEGER NOT NULL DEFAULT 0,           -- number of the newest, never reused
    lease_id            TEXT,
    lease_expires_at_ms INTEGER,
    cancel_requested    INTEGER NOT NULL DEFAULT 0 CHECK (cancel_requested IN (0, 1)),
    progress            TEXT NOT NULL,                        -- JSON
    failure_code        TEXT NOT NULL DEFAULT '',
    failure_message     TEXT NOT NULL DEFAULT '',
    not_before_ms       INTEGER NOT NULL DEFAULT 0,
    created_at_ms       INTEGER NOT NULL,
    started_at_ms       INTEGER NOT NULL DEFAULT 0,
    finished_at_ms      INTEGER NOT NULL DEFAULT 0,
    CHECK (num_attempts BETWEEN 0 AND max_attempts),
    CHECK ((state = 'running') = (lease_id IS NOT NULL)),
    CHECK ((state = 'running') = (lease_expires_at_ms IS NOT NULL))
) STRICT;

CREATE INDEX jobs_due ON jobs (priority DESC, created_at_ms, id) WHERE state = 'queued';
CREATE INDEX jobs_leased ON jobs (lease_expires_at_ms) WHERE state = 'running';
CREATE INDEX jobs_by_age ON jobs (created_at_ms, id);
CREATE INDEX jobs_of_dive ON jobs (dive_id);
CREATE UNIQUE INDEX jobs_one_intake_a_dive ON jobs (dive_id) WHERE kind = 'intake';

-- kJobTransitions of schemas/job_state.hpp; tests/architecture compares the two.
CREATE TRIGGER jobs_obey_their_transitions BEFORE UPDATE OF state ON jobs
WHEN (OLD.state, NEW.state) NOT IN (VALUES
    ('held',      'queued'),
    ('held',      'failed'),
    ('held',      'cancelled'),
    ('queued',    'held'),
    ('queued',    'running'),
    ('queued',    'cancelled'),
    ('running',   'succeeded'),
    ('running',   'failed'),
    ('running',   'queued'),
    ('running',   'dead'),
    ('running',   'cancelled'),
    ('dead',      'queued'),
    ('failed',    'queued'),
    ('cancelled', 'queued'))
BEGIN
    SELECT RAISE(ABORT, 'forbidden job transition');
END;

-- A job is held until all its parents have succeeded.
CREATE TABLE job_parents (
    job_id    TEXT NOT NULL REFERENCES jobs (id),
    parent_id TEXT NOT NULL REFERENCES jobs (id),
    PRIMARY KEY (job_id, parent_id)
) STRICT;

CREATE INDEX job_children ON job_parents (parent_id);

CREATE TABLE attempts (
    job_id          TEXT NOT NULL REFERENCES jobs (id),
    number          INTEGER NOT NULL,
    state           TEXT NOT NULL DEFAULT 'running'
                    CHECK (state IN ('running', 'succeeded', 'failed', 'cancelled', 'lease_lost',
                                     'released')),
    worker          TEXT NOT NULL,
    failure_code    TEXT NOT NULL DEFAULT '',
    failure_message TEXT NOT NULL DEFAULT '',
    log             TEXT NOT NULL DEFAULT '',
    started_at_ms   INTEGER NOT NULL,
    finished_at_ms  INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (job_id, number)
) STRICT;

CREATE UNIQUE INDEX attempts_one_running_a_job ON attempts (job_id) WHERE state = 'running';

CREATE TRIGGER attempts_end_once BEFORE UPDATE OF state ON attempts
WHEN OLD.state <> 'running'
BEGIN
    SELECT RAISE(ABORT, 'forbidden attempt transition');
END;

CREATE TABLE artifacts (
    job_id     TEXT NOT NULL REFERENCES jobs (id),
    name       TEXT NOT NULL,
    media_type TEXT NOT NULL,
    sha256     TEXT NOT NULL,
    size_bytes INTEGER NOT NULL CHECK (size_bytes >= 0),
    blob       TEXT NOT NULL,
    PRIMARY KEY (job_id, name)
) STRICT;

-- The newest sequence is a row of its own: updating it makes writers wait for each other on every
-- engine, so sequences rise in the order of commits.
CREATE TABLE event_sequence (newest INTEGER NOT NULL) STRICT;
INSERT INTO event_sequence (newest) VALUES (0);

CREATE TABLE events (
    sequence INTEGER PRIMARY KEY,
    time_ms  INTEGER NOT NULL,
    project  TEXT NOT NULL,
    topic    TEXT NOT NULL,
    subject  TEXT NOT NULL,
    type     TEXT NOT NULL,
    data     TEXT NOT NULL                                    -- JSON
) STRICT;

CREATE INDEX events_of_subject ON events (subject, type);

CREATE TABLE tokens (
    id              TEXT PRIMARY KEY,
    name            TEXT NOT NULL,
    project         TEXT NOT NULL,
    scopes          TEXT NOT NULL,                            -- JSON
    secret_sha256   TEXT NOT NULL UNIQUE,
    created_at_ms   INTEGER NOT NULL,
    last_used_at_ms INTEGER NOT NULL DEFAULT 0,
    revoked         INTEGER NOT NULL DEFAULT 0 CHECK (revoked IN (0, 1))
) STRICT;
