-- A token may end by itself, and one that pushes is of one sensor.
ALTER TABLE tokens ADD COLUMN sensor TEXT NOT NULL DEFAULT '';
ALTER TABLE tokens ADD COLUMN expires_at_ms INTEGER NOT NULL DEFAULT 0;

-- For one GET of one path, on behalf of a token. The row goes with its use.
CREATE TABLE one_shot_tokens (
    secret_sha256 TEXT PRIMARY KEY,
    token_id      TEXT NOT NULL REFERENCES tokens (id),
    path          TEXT NOT NULL,
    expires_at_ms INTEGER NOT NULL
) STRICT;
