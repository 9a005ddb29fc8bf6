CREATE TABLE webhooks (
    id            TEXT PRIMARY KEY,
    project       TEXT NOT NULL,
    url           TEXT NOT NULL,
    secret        TEXT NOT NULL,                              -- signs: it has to be known
    topics        TEXT NOT NULL,                              -- ' dive job ': blanks around each
    state         TEXT NOT NULL DEFAULT 'enabled' CHECK (state IN ('enabled', 'disabled')),
    created_at_ms INTEGER NOT NULL
) STRICT;

-- The outbox: written in the transaction of the event, emptied by whoever delivers. What was
-- delivered, or given up, stays for a while as the log.
CREATE TABLE webhook_deliveries (
    id             TEXT PRIMARY KEY,
    webhook_id     TEXT NOT NULL REFERENCES webhooks (id),
    type           TEXT NOT NULL,
    body           TEXT NOT NULL,
    state          TEXT NOT NULL DEFAULT 'waiting'
                   CHECK (state IN ('waiting', 'delivered', 'failed')),
    num_attempts   INTEGER NOT NULL DEFAULT 0,
    next_at_ms     INTEGER NOT NULL,
    last_status    INTEGER NOT NULL DEFAULT 0,
    last_error     TEXT NOT NULL DEFAULT '',
    created_at_ms  INTEGER NOT NULL,
    finished_at_ms INTEGER NOT NULL DEFAULT 0
) STRICT;

CREATE INDEX webhook_deliveries_due ON webhook_deliveries (next_at_ms) WHERE state = 'waiting';
CREATE INDEX webhook_deliveries_by_age ON webhook_deliveries (webhook_id, created_at_ms, id);
