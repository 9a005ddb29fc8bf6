-- What people edit of a dive. The columns hold what is shown; what the recording says of an edited
-- field is kept beside them.
ALTER TABLE dives ADD COLUMN notes TEXT NOT NULL DEFAULT '';
ALTER TABLE dives ADD COLUMN position TEXT NOT NULL DEFAULT 'null';  -- JSON
ALTER TABLE dives ADD COLUMN recorded TEXT NOT NULL DEFAULT '{}';    -- JSON
