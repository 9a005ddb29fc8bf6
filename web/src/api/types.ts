import type { components } from "./schema";

// The words of the API by their short names.
type Schemas = components["schemas"];
export type Artifact = Schemas["Artifact"];
export type Attempt = Schemas["Attempt"];
export type Dive = Schemas["Dive"];
export type FigurePoint = Schemas["FigurePoint"];
export type Finding = Schemas["Finding"];
export type Job = Schemas["Job"];
export type JobState = Schemas["JobState"];
export type KindOptions = Schemas["KindOptions"];
export type OptionDescription = Schemas["OptionDescription"];
export type Preset = Schemas["Preset"];
export type Queue = Schemas["Queue"];
export type Scope = Schemas["Scope"];
export type Sensor = Schemas["Sensor"];
export type SensorHistory = Schemas["SensorHistory"];
export type Token = Schemas["Token"];
export type Verdict = Job["verdict"];
export type Webhook = Schemas["Webhook"];
export type WebhookDelivery = Schemas["WebhookDelivery"];
export type Worker = Schemas["Worker"];
export type ServerEvent = Schemas["Event"];
