-- A measured value is a metric; a figure is a drawing.
ALTER TABLE figure_names RENAME TO metric_names;
ALTER TABLE figure_sets RENAME TO metric_sets;
ALTER TABLE figures RENAME TO metric_values;
ALTER TABLE metric_values RENAME COLUMN figure TO metric;

DROP INDEX figure_sets_of_dive;
DROP INDEX figure_sets_of_site;
DROP INDEX figure_sets_of_rig;
DROP INDEX figure_sets_of_measured_job;
DROP INDEX figure_sets_by_time;

CREATE INDEX metric_sets_of_dive ON metric_sets (dive_id);
CREATE INDEX metric_sets_of_site ON metric_sets (site, project);
CREATE INDEX metric_sets_of_rig ON metric_sets (rig, project);
CREATE INDEX metric_sets_of_measured_job ON metric_sets (measured_job_id);
CREATE INDEX metric_sets_by_time ON metric_sets (time_ms);
