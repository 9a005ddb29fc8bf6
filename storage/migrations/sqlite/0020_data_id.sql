-- The id of this catalog and its blob store, one row at most (storage/data_id.hpp). confirmed: 0 until
-- the blob store has it.
CREATE TABLE data_id (
    id        TEXT NOT NULL,
    confirmed INTEGER NOT NULL CHECK (confirmed IN (0, 1))
) STRICT;
