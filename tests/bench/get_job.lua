-- For wrk: GET of jobs at random. Their addresses are the lines of $JOBS, the token is $DIVEMESH_TOKEN.
-- Prints one JSON line.
local paths = {}
for line in io.lines(os.getenv("JOBS")) do paths[#paths + 1] = line end

function init()
  wrk.headers["Authorization"] = "Bearer " .. os.getenv("DIVEMESH_TOKEN")
  math.randomseed(1)
end

function request() return wrk.format("GET", paths[math.random(#paths)]) end

function done(summary, latency)
  local failed = summary.errors.connect + summary.errors.read + summary.errors.write +
                 summary.errors.status + summary.errors.timeout
  print(string.format(
    '{"requests": %d, "requests_per_s": %.0f, "p50_ms": %.2f, "p99_ms": %.2f, "failed": %d}',
    summary.requests, summary.requests / summary.duration * 1e6,
    latency:percentile(50) / 1000, latency:percentile(99) / 1000, failed))
end
