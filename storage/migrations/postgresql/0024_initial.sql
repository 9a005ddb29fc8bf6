-- The schema of version 24 as a whole: no PostgreSQL catalog is older. Later versions are files of
-- their own, with the numbers of those in ../sqlite, which also say why a table is as it is.
-- tests/storage/schema_test.cpp compares the two schemas.
-- Text sorts by its bytes, as in SQLite, whatever the database's collation is.
-- Times are unix milliseconds of the catalog's clock. Ids are made by us, never by a client.

CREATE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION '%', TG_ARGV[0];
END $$;

CREATE TABLE dives (
    id             TEXT COLLATE "C" PRIMARY KEY,
    project        TEXT COLLATE "C" NOT NULL,
    state          TEXT COLLATE "C" NOT NULL DEFAULT 'checking'
                   CHECK (state IN ('checking', 'ready', 'refused')),
    name           TEXT COLLATE "C" NOT NULL,
    site           TEXT COLLATE "C" NOT NULL DEFAULT '',
    tags           TEXT COLLATE "C" NOT NULL DEFAULT '[]',    -- JSON
    archive_sha256 TEXT COLLATE "C" NOT NULL,
    content_sha256 TEXT COLLATE "C" NOT NULL DEFAULT '',
    archive_bytes  BIGINT NOT NULL CHECK (archive_bytes >= 0),
    blob           TEXT COLLATE "C" NOT NULL,
    num_frames     BIGINT NOT NULL DEFAULT 0,
    duration_s     DOUBLE PRECISION NOT NULL DEFAULT 0,
    findings       TEXT COLLATE "C" NOT NULL DEFAULT '[]',    -- JSON
    thumbnail_blob TEXT COLLATE "C" NOT NULL DEFAULT '',
    created_at_ms  BIGINT NOT NULL,
    deleted_at_ms  BIGINT NOT NULL DEFAULT 0,
    expires_at_ms  BIGINT NOT NULL DEFAULT 0,
    rig            TEXT COLLATE "C" NOT NULL DEFAULT '',
    notes          TEXT COLLATE "C" NOT NULL DEFAULT '',
    position       TEXT COLLATE "C" NOT NULL DEFAULT 'null',  -- JSON
    recorded       TEXT COLLATE "C" NOT NULL DEFAULT '{}'     -- JSON
);
CREATE INDEX dives_by_age ON dives (created_at_ms, id);
CREATE INDEX dives_to_remove ON dives (expires_at_ms) WHERE deleted_at_ms > 0;
CREATE UNIQUE INDEX dives_content_once ON dives (project, content_sha256)
    WHERE content_sha256 <> '' AND state <> 'refused' AND deleted_at_ms = 0;
CREATE UNIQUE INDEX dives_archive_once ON dives (project, archive_sha256)
    WHERE archive_sha256 <> '' AND state <> 'refused' AND deleted_at_ms = 0;
CREATE TRIGGER dives_are_judged_once BEFORE UPDATE OF state ON dives FOR EACH ROW
WHEN (OLD.state <> 'checking' OR NEW.state = 'checking')
EXECUTE FUNCTION refuse_change('forbidden dive transition');

CREATE TABLE jobs (
    id                  TEXT COLLATE "C" PRIMARY KEY,
    project             TEXT COLLATE "C" NOT NULL,
    dive_id             TEXT COLLATE "C" NOT NULL REFERENCES dives (id),
    kind                TEXT COLLATE "C" NOT NULL
                        CHECK (kind IN ('intake', 'reconstruct', 'accuracy_report', 'compare')),
    state               TEXT COLLATE "C" NOT NULL
                        CHECK (state IN ('held', 'queued', 'running', 'succeeded', 'failed', 'dead',
                                         'cancelled')),
    preset              TEXT COLLATE "C" NOT NULL DEFAULT '',
    options             TEXT COLLATE "C" NOT NULL DEFAULT '{}',  -- JSON
    priority            BIGINT NOT NULL DEFAULT 0,
    num_attempts        BIGINT NOT NULL DEFAULT 0,            -- that count towards the maximum
    max_attempts        BIGINT NOT NULL CHECK (max_attempts >= 1),
    attempt             BIGINT NOT NULL DEFAULT 0,            -- number of the newest, never reused
    lease_id            TEXT COLLATE "C",
    lease_expires_at_ms BIGINT,
    cancel_requested    BIGINT NOT NULL DEFAULT 0 CHECK (cancel_requested IN (0, 1)),
    progress            TEXT COLLATE "C" NOT NULL,            -- JSON
    failure_code        TEXT COLLATE "C" NOT NULL DEFAULT '',
    failure_message     TEXT COLLATE "C" NOT NULL DEFAULT '',
    not_before_ms       BIGINT NOT NULL DEFAULT 0,
    created_at_ms       BIGINT NOT NULL,
    started_at_ms       BIGINT NOT NULL DEFAULT 0,
    finished_at_ms      BIGINT NOT NULL DEFAULT 0,
    parents             TEXT COLLATE "C" NOT NULL DEFAULT '[]',  -- JSON, as in job_parents
    paused              BIGINT NOT NULL DEFAULT 0 CHECK (paused IN (0, 1)),
    lowered             BIGINT NOT NULL DEFAULT 0 CHECK (lowered IN (0, 1)),
    stages              TEXT COLLATE "C" NOT NULL DEFAULT '[]',  -- JSON, of the newest attempt
    failure_remedy      TEXT COLLATE "C" NOT NULL DEFAULT '',
    unique_key          TEXT COLLATE "C" NOT NULL DEFAULT '',  -- kind, preset, options
    queue_rank_ms       BIGINT NOT NULL DEFAULT 0,            -- the least is first
    lease_ms            BIGINT NOT NULL DEFAULT 0,            -- how long it was given for
    lease_renewed       BIGINT NOT NULL DEFAULT 0 CHECK (lease_renewed IN (0, 1)),
    num_silent_losses   BIGINT NOT NULL DEFAULT 0,            -- in a row, never renewed
    requirements        TEXT COLLATE "C" NOT NULL DEFAULT '[]',  -- JSON, of a success
    verdict             TEXT COLLATE "C" NOT NULL DEFAULT ''
                        CHECK (verdict IN ('', 'good', 'usable_with_restrictions', 'not_usable')),
    findings            TEXT COLLATE "C" NOT NULL DEFAULT '[]',  -- JSON
    result_bytes        BIGINT NOT NULL DEFAULT 0,            -- of its artifacts
    deleted_at_ms       BIGINT NOT NULL DEFAULT 0,
    expires_at_ms       BIGINT NOT NULL DEFAULT 0,
    kept                BIGINT NOT NULL DEFAULT 0,            -- 1: restored, so no rule deletes it
    CHECK (num_attempts BETWEEN 0 AND max_attempts),
    CHECK ((state = 'running') = (lease_id IS NOT NULL)),
    CHECK ((state = 'running') = (lease_expires_at_ms IS NOT NULL))
);
CREATE INDEX jobs_leased ON jobs (lease_expires_at_ms) WHERE state = 'running';
CREATE INDEX jobs_by_age ON jobs (created_at_ms, id);
CREATE INDEX jobs_of_dive ON jobs (dive_id);
CREATE UNIQUE INDEX jobs_one_intake_a_dive ON jobs (dive_id) WHERE kind = 'intake';
CREATE INDEX jobs_due ON jobs (queue_rank_ms, id, project, kind, not_before_ms)
    WHERE state = 'queued';
CREATE UNIQUE INDEX jobs_once ON jobs (dive_id, unique_key)
    WHERE state IN ('held', 'queued', 'running');
CREATE INDEX jobs_results_of_project ON jobs (project, result_bytes) WHERE result_bytes > 0;
CREATE INDEX jobs_to_remove ON jobs (expires_at_ms) WHERE deleted_at_ms > 0;

-- kJobTransitions of schemas/job_state.hpp; tests/architecture compares the two.
CREATE TRIGGER jobs_obey_their_transitions BEFORE UPDATE OF state ON jobs FOR EACH ROW
WHEN ((OLD.state, NEW.state) NOT IN (
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
    ('failed',    'held'),
    ('cancelled', 'queued')))
EXECUTE FUNCTION refuse_change('forbidden job transition');

-- Of this engine alone: workers that wait for jobs hear of them (storage/queue_signal.hpp).
CREATE FUNCTION wake_workers() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM pg_notify('divemesh_queue', '');
    RETURN NULL;
END $$;

CREATE TRIGGER jobs_wake_workers AFTER INSERT OR UPDATE OF state ON jobs FOR EACH ROW
WHEN (NEW.state = 'queued')
EXECUTE FUNCTION wake_workers();

CREATE TABLE job_parents (
    job_id    TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    parent_id TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    PRIMARY KEY (job_id, parent_id)
);
CREATE INDEX job_children ON job_parents (parent_id);

CREATE FUNCTION require_no_children() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF NEW.job_id = NEW.parent_id
        OR EXISTS (SELECT 1 FROM job_parents WHERE parent_id = NEW.job_id) THEN
        RAISE EXCEPTION 'a job cannot wait for one that waits for it';
    END IF;
    RETURN NEW;
END $$;

CREATE TRIGGER job_parents_come_first BEFORE INSERT ON job_parents FOR EACH ROW
EXECUTE FUNCTION require_no_children();

CREATE TRIGGER job_parents_stay BEFORE UPDATE ON job_parents FOR EACH ROW
EXECUTE FUNCTION refuse_change('the parents of a job do not change');

CREATE TABLE attempts (
    job_id          TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    number          BIGINT NOT NULL,
    state           TEXT COLLATE "C" NOT NULL DEFAULT 'running'
                    CHECK (state IN ('running', 'succeeded', 'failed', 'cancelled', 'lease_lost',
                                     'released')),
    worker          TEXT COLLATE "C" NOT NULL,
    failure_code    TEXT COLLATE "C" NOT NULL DEFAULT '',
    failure_message TEXT COLLATE "C" NOT NULL DEFAULT '',
    log             TEXT COLLATE "C" NOT NULL DEFAULT '',
    started_at_ms   BIGINT NOT NULL,
    finished_at_ms  BIGINT NOT NULL DEFAULT 0,
    failure_remedy  TEXT COLLATE "C" NOT NULL DEFAULT '',
    cleaned         BIGINT NOT NULL DEFAULT 0,
    PRIMARY KEY (job_id, number)
);
CREATE UNIQUE INDEX attempts_one_running_a_job ON attempts (job_id) WHERE state = 'running';
CREATE INDEX attempts_to_clean ON attempts (finished_at_ms)
    WHERE cleaned = 0 AND state NOT IN ('running', 'succeeded');
CREATE TRIGGER attempts_end_once BEFORE UPDATE OF state ON attempts FOR EACH ROW
WHEN (OLD.state <> 'running')
EXECUTE FUNCTION refuse_change('forbidden attempt transition');

CREATE TABLE artifacts (
    job_id     TEXT COLLATE "C" NOT NULL REFERENCES jobs (id),
    name       TEXT COLLATE "C" NOT NULL,
    media_type TEXT COLLATE "C" NOT NULL,
    sha256     TEXT COLLATE "C" NOT NULL,
    size_bytes BIGINT NOT NULL CHECK (size_bytes >= 0),
    blob       TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (job_id, name)
);

CREATE FUNCTION count_artifact() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET result_bytes = result_bytes + NEW.size_bytes WHERE id = NEW.job_id;
    RETURN NULL;
END $$;

CREATE FUNCTION count_removed_artifact() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET result_bytes = result_bytes - OLD.size_bytes WHERE id = OLD.job_id;
    RETURN NULL;
END $$;

CREATE TRIGGER artifacts_are_counted AFTER INSERT ON artifacts FOR EACH ROW
EXECUTE FUNCTION count_artifact();
CREATE TRIGGER removed_artifacts_are_not_counted AFTER DELETE ON artifacts FOR EACH ROW
EXECUTE FUNCTION count_removed_artifact();

-- The newest sequence is a row of its own: updating it makes writers wait for each other, so
-- sequences rise in the order of commits.
CREATE TABLE event_sequence (newest BIGINT NOT NULL);
INSERT INTO event_sequence (newest) VALUES (0);

CREATE TABLE events (
    sequence BIGINT PRIMARY KEY,
    time_ms  BIGINT NOT NULL,
    project  TEXT COLLATE "C" NOT NULL,
    topic    TEXT COLLATE "C" NOT NULL,
    subject  TEXT COLLATE "C" NOT NULL,
    type     TEXT COLLATE "C" NOT NULL,
    data     TEXT COLLATE "C" NOT NULL                        -- JSON
);
CREATE INDEX events_of_subject ON events (subject, type);
CREATE INDEX events_by_time ON events (time_ms);

CREATE TABLE tokens (
    id              TEXT COLLATE "C" PRIMARY KEY,
    name            TEXT COLLATE "C" NOT NULL,
    project         TEXT COLLATE "C" NOT NULL,
    scopes          TEXT COLLATE "C" NOT NULL,                -- JSON
    secret_sha256   TEXT COLLATE "C" NOT NULL UNIQUE,
    created_at_ms   BIGINT NOT NULL,
    last_used_at_ms BIGINT NOT NULL DEFAULT 0,
    revoked         BIGINT NOT NULL DEFAULT 0 CHECK (revoked IN (0, 1)),
    sensor          TEXT COLLATE "C" NOT NULL DEFAULT '',
    expires_at_ms   BIGINT NOT NULL DEFAULT 0,
    shared_job      TEXT COLLATE "C" NOT NULL DEFAULT ''
);
CREATE INDEX tokens_of_shared_job ON tokens (shared_job, created_at_ms) WHERE shared_job <> '';

CREATE TABLE queues (
    project      TEXT COLLATE "C" PRIMARY KEY,
    paused       BIGINT NOT NULL DEFAULT 0 CHECK (paused IN (0, 1)),
    max_running  BIGINT NOT NULL DEFAULT 0 CHECK (max_running >= 0),  -- 0: no limit
    keep_results BIGINT NOT NULL DEFAULT 0 CHECK (keep_results >= 0)  -- of a dive and kind; 0: all
);

CREATE TABLE workers (
    name          TEXT COLLATE "C" PRIMARY KEY,
    num_slots     BIGINT NOT NULL CHECK (num_slots >= 1),
    draining      BIGINT NOT NULL DEFAULT 0 CHECK (draining IN (0, 1)),
    started_at_ms BIGINT NOT NULL,
    seen_at_ms    BIGINT NOT NULL,
    waits_for     TEXT COLLATE "C" NOT NULL DEFAULT ''
);

CREATE TABLE job_speeds (
    kind             TEXT COLLATE "C" NOT NULL,
    preset           TEXT COLLATE "C" NOT NULL,
    seconds_per_unit DOUBLE PRECISION NOT NULL,
    PRIMARY KEY (kind, preset)
);

CREATE TABLE uploads (
    id             TEXT COLLATE "C" PRIMARY KEY,
    project        TEXT COLLATE "C" NOT NULL,
    length_bytes   BIGINT CHECK (length_bytes >= 0),          -- null until it is told
    offset_bytes   BIGINT NOT NULL DEFAULT 0 CHECK (offset_bytes >= 0),
    metadata       TEXT COLLATE "C" NOT NULL,
    concat         TEXT COLLATE "C" NOT NULL DEFAULT '',      -- Upload-Concat, as it came
    blob           TEXT COLLATE "C" NOT NULL UNIQUE,
    dive_id        TEXT COLLATE "C" REFERENCES dives (id),    -- null until it became one
    ended          TEXT COLLATE "C" NOT NULL DEFAULT ''
                   CHECK (ended IN ('', 'terminated', 'expired', 'concatenated')),
    bytes_freed    BIGINT NOT NULL DEFAULT 0 CHECK (bytes_freed IN (0, 1)),
    created_at_ms  BIGINT NOT NULL,
    touched_at_ms  BIGINT NOT NULL,                           -- created, advanced or ended
    lifetime_ms    BIGINT NOT NULL CHECK (lifetime_ms > 0),   -- from touch to expiry
    repeated_bytes BIGINT NOT NULL DEFAULT 0 CHECK (repeated_bytes >= 0),
    token_id       TEXT COLLATE "C" NOT NULL DEFAULT '',
    truth_id       TEXT COLLATE "C" NOT NULL DEFAULT '',      -- '': it became none
    CHECK (length_bytes IS NULL OR offset_bytes <= length_bytes)
);
CREATE INDEX uploads_open ON uploads (touched_at_ms) WHERE dive_id IS NULL AND ended = '';
CREATE INDEX uploads_open_of_project ON uploads (project) WHERE dive_id IS NULL AND ended = '';
CREATE INDEX uploads_ended ON uploads (touched_at_ms) WHERE ended <> '';
CREATE INDEX uploads_open_of_token ON uploads (token_id) WHERE dive_id IS NULL AND ended = '';
CREATE TRIGGER uploads_never_shrink BEFORE UPDATE OF offset_bytes ON uploads FOR EACH ROW
WHEN (NEW.offset_bytes < OLD.offset_bytes)
EXECUTE FUNCTION refuse_change('the offset of an upload never goes down');
CREATE TRIGGER uploads_end_once BEFORE UPDATE OF ended ON uploads FOR EACH ROW
WHEN (OLD.ended <> '')
EXECUTE FUNCTION refuse_change('forbidden upload transition');

CREATE TABLE idempotent_answers (
    token_id      TEXT COLLATE "C" NOT NULL,
    key           TEXT COLLATE "C" NOT NULL,
    fingerprint   TEXT COLLATE "C" NOT NULL,                  -- SHA-256 of the request
    status        BIGINT NOT NULL,
    headers       TEXT COLLATE "C" NOT NULL,                  -- JSON
    body          TEXT COLLATE "C" NOT NULL,
    created_at_ms BIGINT NOT NULL,
    PRIMARY KEY (token_id, key)
);
CREATE INDEX idempotent_answers_by_age ON idempotent_answers (created_at_ms);

CREATE TABLE one_shot_tokens (
    secret_sha256 TEXT COLLATE "C" PRIMARY KEY,
    token_id      TEXT COLLATE "C" NOT NULL REFERENCES tokens (id),
    path          TEXT COLLATE "C" NOT NULL,
    expires_at_ms BIGINT NOT NULL
);

CREATE TABLE dive_tags (
    dive_id TEXT COLLATE "C" NOT NULL REFERENCES dives (id),
    tag     TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (dive_id, tag)
);
CREATE INDEX dives_by_tag ON dive_tags (tag);

CREATE TABLE webhooks (
    id            TEXT COLLATE "C" PRIMARY KEY,
    project       TEXT COLLATE "C" NOT NULL,
    url           TEXT COLLATE "C" NOT NULL,
    secret        TEXT COLLATE "C" NOT NULL,                  -- signs: it has to be known
    topics        TEXT COLLATE "C" NOT NULL,                  -- ' dive job ': blanks around each
    state         TEXT COLLATE "C" NOT NULL DEFAULT 'enabled'
                  CHECK (state IN ('enabled', 'disabled')),
    created_at_ms BIGINT NOT NULL
);

CREATE TABLE webhook_deliveries (
    id             TEXT COLLATE "C" PRIMARY KEY,
    webhook_id     TEXT COLLATE "C" NOT NULL REFERENCES webhooks (id),
    type           TEXT COLLATE "C" NOT NULL,
    body           TEXT COLLATE "C" NOT NULL,
    state          TEXT COLLATE "C" NOT NULL DEFAULT 'waiting'
                   CHECK (state IN ('waiting', 'delivered', 'failed')),
    num_attempts   BIGINT NOT NULL DEFAULT 0,
    next_at_ms     BIGINT NOT NULL,
    last_status    BIGINT NOT NULL DEFAULT 0,
    last_error     TEXT COLLATE "C" NOT NULL DEFAULT '',
    created_at_ms  BIGINT NOT NULL,
    finished_at_ms BIGINT NOT NULL DEFAULT 0
);
CREATE INDEX webhook_deliveries_due ON webhook_deliveries (next_at_ms) WHERE state = 'waiting';
CREATE INDEX webhook_deliveries_by_age ON webhook_deliveries (webhook_id, created_at_ms, id);

CREATE TABLE requested_jobs (
    request_key   TEXT COLLATE "C" NOT NULL PRIMARY KEY,      -- NewJob::request_key
    job_id        TEXT COLLATE "C" NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    created_at_ms BIGINT NOT NULL
);
CREATE INDEX requested_jobs_by_age ON requested_jobs (created_at_ms);
CREATE INDEX requested_jobs_of_job ON requested_jobs (job_id);

CREATE TABLE upload_parts (
    final_id TEXT COLLATE "C" NOT NULL REFERENCES uploads (id) ON DELETE CASCADE,
    part_id  TEXT COLLATE "C" NOT NULL REFERENCES uploads (id) ON DELETE CASCADE,
    PRIMARY KEY (final_id, part_id)
);
CREATE INDEX upload_parts_by_part ON upload_parts (part_id);

CREATE TABLE stage_seconds (
    stage    TEXT COLLATE "C" NOT NULL,
    cached   BIGINT NOT NULL CHECK (cached IN (0, 1)),        -- 1: taken from the cache
    up_to_s  DOUBLE PRECISION NOT NULL,
    num_runs BIGINT NOT NULL,
    total_s  DOUBLE PRECISION NOT NULL,
    PRIMARY KEY (stage, cached, up_to_s)
);

CREATE TABLE sensors (
    number          BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY,
    id              TEXT COLLATE "C" NOT NULL UNIQUE,
    project         TEXT COLLATE "C" NOT NULL,
    state           TEXT COLLATE "C" NOT NULL                 -- the last that was told as an event
                    CHECK (state IN ('online', 'idle', 'submerged', 'overdue', 'lost')),
    alarms          TEXT COLLATE "C" NOT NULL DEFAULT '[]',   -- JSON
    boot            BIGINT NOT NULL DEFAULT 0,                -- sensor_boots.number of what is told
    num_lives       BIGINT NOT NULL DEFAULT 0,                -- boots that spoke of now
    hello           TEXT COLLATE "C" NOT NULL DEFAULT '{}',   -- JSON
    status          TEXT COLLATE "C" NOT NULL DEFAULT '{}',   -- JSON, the newest of now
    status_at_ms    BIGINT NOT NULL DEFAULT 0,
    status_sequence BIGINT NOT NULL DEFAULT -1,
    seen_at_ms      BIGINT NOT NULL,
    back_at_ms      BIGINT NOT NULL DEFAULT 0,                -- 0: no dive announced
    twin_at_ms      BIGINT NOT NULL DEFAULT 0,                -- a boot that was superseded spoke
    created_at_ms   BIGINT NOT NULL,
    previews        TEXT COLLATE "C" NOT NULL DEFAULT '{}'    -- JSON, the newest by camera
);
CREATE INDEX sensors_by_age ON sensors (created_at_ms, id);

CREATE TABLE sensor_boots (
    sensor     BIGINT NOT NULL REFERENCES sensors (number),
    number     BIGINT NOT NULL,
    boot_id    TEXT COLLATE "C" NOT NULL,
    life       BIGINT NOT NULL DEFAULT 0,
    epoch_ms   BIGINT,                                        -- when its uptime was 0
    received   TEXT COLLATE "C" NOT NULL,                     -- JSON, sequence ranges
    seen_at_ms BIGINT NOT NULL,
    PRIMARY KEY (sensor, number)
);
CREATE UNIQUE INDEX sensor_boots_once ON sensor_boots (sensor, boot_id);

CREATE TABLE sensor_statuses (
    sensor             BIGINT NOT NULL,
    time_ms            BIGINT NOT NULL,
    boot               BIGINT NOT NULL,
    sequence           BIGINT NOT NULL,
    recording          DOUBLE PRECISION,
    num_frames         DOUBLE PRECISION,
    num_dropped_frames DOUBLE PRECISION,
    frame_rate_hz      DOUBLE PRECISION,
    storage_free_bytes DOUBLE PRECISION,
    battery            DOUBLE PRECISION,
    depth_m            DOUBLE PRECISION,
    temperature_c      DOUBLE PRECISION,
    leak               DOUBLE PRECISION,
    humidity           DOUBLE PRECISION,
    imu_rate_hz        DOUBLE PRECISION,
    link_rssi_dbm      DOUBLE PRECISION,
    link_bytes_per_s   DOUBLE PRECISION,
    clock_offset_ms    DOUBLE PRECISION,
    more               TEXT COLLATE "C" NOT NULL,             -- JSON, the rest as it came
    PRIMARY KEY (sensor, time_ms, boot, sequence)
);

CREATE TABLE sensor_previews (
    number    BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY,
    sensor    BIGINT NOT NULL REFERENCES sensors (number),
    time_ms   BIGINT NOT NULL,
    camera    TEXT COLLATE "C" NOT NULL,
    width     BIGINT NOT NULL,
    height    BIGINT NOT NULL,
    num_bytes BIGINT NOT NULL,
    sha256    TEXT COLLATE "C" NOT NULL,
    about     TEXT COLLATE "C" NOT NULL,                      -- JSON, the rest as it came
    jpeg      BYTEA NOT NULL
);
CREATE INDEX sensor_previews_by_time ON sensor_previews (sensor, time_ms, number);

CREATE TABLE sensor_commands (
    number        BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY,
    id            TEXT COLLATE "C" NOT NULL UNIQUE,
    sensor        BIGINT NOT NULL REFERENCES sensors (number),
    name          TEXT COLLATE "C" NOT NULL,
    arguments     TEXT COLLATE "C" NOT NULL,                  -- JSON
    state         TEXT COLLATE "C" NOT NULL
                  CHECK (state IN ('pending', 'sent', 'done', 'failed', 'refused', 'expired')),
    detail        TEXT COLLATE "C" NOT NULL DEFAULT '',
    requested_by  TEXT COLLATE "C" NOT NULL,
    created_at_ms BIGINT NOT NULL,
    expires_at_ms BIGINT NOT NULL,
    sent_at_ms    BIGINT NOT NULL DEFAULT 0,
    ended_at_ms   BIGINT NOT NULL DEFAULT 0
);
CREATE INDEX sensor_commands_of_sensor ON sensor_commands (sensor, number);
CREATE INDEX sensor_commands_open ON sensor_commands (expires_at_ms)
    WHERE state IN ('pending', 'sent');

CREATE TABLE truth_files (
    id            TEXT COLLATE "C" PRIMARY KEY,
    project       TEXT COLLATE "C" NOT NULL,
    dive_id       TEXT COLLATE "C" NOT NULL REFERENCES dives (id),
    kind          TEXT COLLATE "C" NOT NULL
                  CHECK (kind IN ('ground_truth', 'reference', 'measurements', 'areas')),
    name          TEXT COLLATE "C" NOT NULL,
    sha256        TEXT COLLATE "C" NOT NULL,
    size_bytes    BIGINT NOT NULL CHECK (size_bytes >= 0),
    blob          TEXT COLLATE "C" NOT NULL UNIQUE,
    created_at_ms BIGINT NOT NULL,
    deleted_at_ms BIGINT NOT NULL DEFAULT 0,                  -- > 0: its blob is still to go
    problem       TEXT COLLATE "C" NOT NULL DEFAULT ''
);
CREATE UNIQUE INDEX truth_files_once ON truth_files (dive_id, kind, sha256)
    WHERE deleted_at_ms = 0;
CREATE INDEX truth_files_of_dive ON truth_files (dive_id, created_at_ms, id);
CREATE INDEX truth_files_of_project ON truth_files (project, size_bytes);
CREATE INDEX truth_files_to_remove ON truth_files (deleted_at_ms) WHERE deleted_at_ms > 0;
CREATE TRIGGER truth_files_stay BEFORE UPDATE OF dive_id, kind, name, sha256, size_bytes, blob
ON truth_files FOR EACH ROW
EXECUTE FUNCTION refuse_change('a file of truth never changes');

CREATE TABLE metric_names (
    number BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY,
    name   TEXT COLLATE "C" NOT NULL UNIQUE,
    unit   TEXT COLLATE "C" NOT NULL,
    method TEXT COLLATE "C" NOT NULL
);

CREATE TABLE metric_sets (
    number             BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY,
    job_id             TEXT COLLATE "C" NOT NULL UNIQUE REFERENCES jobs (id),
    measured_job_id    TEXT COLLATE "C" NOT NULL,             -- the reconstruction
    project            TEXT COLLATE "C" NOT NULL,
    dive_id            TEXT COLLATE "C" NOT NULL REFERENCES dives (id),
    kind               TEXT COLLATE "C" NOT NULL,
    site               TEXT COLLATE "C" NOT NULL,
    rig                TEXT COLLATE "C" NOT NULL,
    preset             TEXT COLLATE "C" NOT NULL,
    version            TEXT COLLATE "C" NOT NULL,
    calibration_sha256 TEXT COLLATE "C" NOT NULL,
    time_ms            BIGINT NOT NULL
);
CREATE INDEX metric_sets_of_dive ON metric_sets (dive_id);
CREATE INDEX metric_sets_of_site ON metric_sets (site, project);
CREATE INDEX metric_sets_of_rig ON metric_sets (rig, project);
CREATE INDEX metric_sets_of_measured_job ON metric_sets (measured_job_id);
CREATE INDEX metric_sets_by_time ON metric_sets (time_ms);

CREATE TABLE metric_values (
    metric     BIGINT NOT NULL REFERENCES metric_names (number),
    set_number BIGINT NOT NULL REFERENCES metric_sets (number),
    value      DOUBLE PRECISION NOT NULL,
    PRIMARY KEY (metric, set_number)
);

CREATE TABLE schedules (
    id            TEXT COLLATE "C" PRIMARY KEY,
    project       TEXT COLLATE "C" NOT NULL,
    cron          TEXT COLLATE "C" NOT NULL,
    tag           TEXT COLLATE "C" NOT NULL,
    preset        TEXT COLLATE "C" NOT NULL,
    options       TEXT COLLATE "C" NOT NULL,                  -- JSON, of the reports
    created_at_ms BIGINT NOT NULL,
    next_run_ms   BIGINT NOT NULL,
    last_run_ms   BIGINT NOT NULL DEFAULT 0,
    last_num_jobs BIGINT NOT NULL DEFAULT 0,
    last_problem  TEXT COLLATE "C" NOT NULL DEFAULT ''
);
CREATE INDEX schedules_due ON schedules (next_run_ms);

CREATE TABLE data_id (
    id        TEXT COLLATE "C" NOT NULL,
    confirmed BIGINT NOT NULL CHECK (confirmed IN (0, 1))
);

CREATE TABLE browser_sessions (
    secret_sha256   TEXT COLLATE "C" PRIMARY KEY,
    token_id        TEXT COLLATE "C" NOT NULL REFERENCES tokens (id),
    created_at_ms   BIGINT NOT NULL,
    last_used_at_ms BIGINT NOT NULL
);
CREATE INDEX browser_sessions_token ON browser_sessions (token_id, created_at_ms);
