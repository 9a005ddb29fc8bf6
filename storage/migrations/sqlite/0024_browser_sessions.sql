-- What a cookie of the web page stands for: a token, until the session ends or the token does.
CREATE TABLE browser_sessions (
    secret_sha256   TEXT PRIMARY KEY,
    token_id        TEXT NOT NULL REFERENCES tokens (id),
    created_at_ms   INTEGER NOT NULL,
    last_used_at_ms INTEGER NOT NULL
) STRICT;
CREATE INDEX browser_sessions_token ON browser_sessions (token_id, created_at_ms);
