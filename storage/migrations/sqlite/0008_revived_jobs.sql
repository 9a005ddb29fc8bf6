-- A job that failed with its parent waits for it again when the parent is asked for again.
DROP TRIGGER jobs_obey_their_transitions;

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
    ('failed',    'held'),
    ('cancelled', 'queued'))
BEGIN
    SELECT RAISE(ABORT, 'forbidden job transition');
END;
