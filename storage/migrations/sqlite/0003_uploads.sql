-- Uploads whose length is told later, that are parts of another or made of parts, and that end.
CREATE TABLE uploads_next (
    id            TEXT PRIMARY KEY,
    project       TEXT NOT NULL,
    length_bytes  INTEGER CHECK (length_bytes >= 0),          -- null until it is told
    offset_bytes  INTEGER NOT NULL DEFAULT 0 CHECK (offset_bytes >= 0),
    metadata      TEXT NOT NULL,
    concat        TEXT NOT NULL DEFAULT '',                   -- Upload-Concat, as it came
    blob          TEXT NOT NULL UNIQUE,
    dive_id       TEXT REFERENCES dives (id),                 -- null until it became one
    ended         TEXT NOT NULL DEFAULT ''
                  CHECK (ended IN ('', 'terminated', 'expired', 'concatenated')),
    bytes_freed   INTEGER NOT NULL DEFAULT 0 CHECK (bytes_freed IN (0, 1)),
    created_at_ms INTEGER NOT NULL,
    touched_at_ms INTEGER NOT NULL,                           -- created, advanced or ended
    lifetime_ms   INTEGER NOT NULL CHECK (lifetime_ms > 0),   -- from touch to expiry
    CHECK (length_bytes IS NULL OR offset_bytes <= length_bytes)
) STRICT;

INSERT INTO uploads_next (id, project, length_bytes, offset_bytes, metadata, blob, dive_id,
                          created_at_ms, touched_at_ms, lifetime_ms)
SELECT id, project, length_bytes, offset_bytes, metadata, blob, dive_id,
       created_at_ms, touched_at_ms, 604800000
FROM uploads;

DROP TABLE uploads;
ALTER TABLE uploads_next RENAME TO uploads;

CREATE INDEX uploads_open ON uploads (touched_at_ms) WHERE dive_id IS NULL AND ended = '';
CREATE INDEX uploads_open_of_project ON uploads (project) WHERE dive_id IS NULL AND ended = '';
CREATE INDEX uploads_ended ON uploads (touched_at_ms) WHERE ended <> '';

CREATE TRIGGER uploads_never_shrink BEFORE UPDATE OF offset_bytes ON uploads
WHEN NEW.offset_bytes < OLD.offset_bytes
BEGIN
    SELECT RAISE(ABORT, 'the offset of an upload never goes down');
END;

CREATE TRIGGER uploads_end_once BEFORE UPDATE OF ended ON uploads
WHEN OLD.ended <> ''
BEGIN
    SELECT RAISE(ABORT, 'forbidden upload transition');
END;

-- Answers to requests that carried an Idempotency-Key, kept to be given again.
CREATE TABLE idempotent_answers (
    token_id      TEXT NOT NULL,
    key           TEXT NOT NULL,
    fingerprint   TEXT NOT NULL,                              -- SHA-256 of the request
    status        INTEGER NOT NULL,
    headers       TEXT NOT NULL,                              -- JSON
    body          TEXT NOT NULL,
    created_at_ms INTEGER NOT NULL,
    PRIMARY KEY (token_id, key)
) STRICT;

CREATE INDEX idempotent_answers_by_age ON idempotent_answers (created_at_ms);
