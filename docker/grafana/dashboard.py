# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints a dashboard that Grafana can import: /usr/bin/python3 docker/grafana/dashboard.py > dashboard.json

ROWS lists the panels. In their queries, metrics are restricted to the servers selected on the dashboard, and [] is the
interval that Grafana chooses.
"""

import json
import re
import string

JOBS = 'job="ccdt", instance=~"$instance"'
SOURCE = {"type": "prometheus", "uid": "${datasource}"}
WIDTH = 24  # width of the dashboard, in Grafana's units


def query(short):
    """Returns a query in PromQL, with its metrics restricted to the selected servers."""
    def selected(match):
        labels = f", {match[2]}" if match[2] else ""
        return f"{match[1]}{{{JOBS}{labels}}}"

    return re.sub(r"\b(up|(?:ccdt|process)_\w+)(?:\{(.*?)\})?", selected, short).replace("[]", "[$__rate_interval]")


def panel(kind, title, description, unit, queries, **settings):
    """Returns a panel without its position. `queries` maps legends to queries.

    Settings: `red_from` and `red_below` are thresholds, `at_most` is the upper end of the axis, `stacked` stacks the
    areas.
    """
    defaults = {"unit": unit, "min": 0}
    if "at_most" in settings:
        defaults["max"] = settings["at_most"]
    for setting, colours in (("red_below", ("red", "green")), ("red_from", ("green", "red"))):
        if setting in settings:
            steps = zip(colours, (None, settings[setting]))
            defaults["thresholds"] = {"mode": "absolute", "steps": [{"color": c, "value": v} for c, v in steps]}
    if kind == "stat":
        options = {"colorMode": "background", "graphMode": "none", "reduceOptions": {"calcs": ["lastNotNull"]}}
    else:
        options = {"legend": {"displayMode": "list", "placement": "bottom"},
                   "tooltip": {"mode": "multi", "sort": "desc"}}
        defaults["custom"] = {"fillOpacity": 10, "showPoints": "never"}
        if "stacked" in settings:
            defaults["custom"] |= {"fillOpacity": 30, "stacking": {"mode": "normal"}}
        if "thresholds" in defaults:
            defaults["custom"]["thresholdsStyle"] = {"mode": "dashed"}
    targets = [{"refId": letter, "datasource": SOURCE, "expr": query(short), "legendFormat": legend}
               for letter, (legend, short) in zip(string.ascii_uppercase, queries.items())]
    return {"type": kind, "title": title, "description": description, "datasource": SOURCE,
            "fieldConfig": {"defaults": defaults, "overrides": []}, "options": options, "targets": targets}


def number(*arguments, **settings):
    return panel("stat", *arguments, **settings)


def chart(*arguments, **settings):
    return panel("timeseries", *arguments, **settings)


COMPUTED = 'route=~"/halftone.*|/sample|/analyze"'
NOT_PROBES = 'route!~"/health.*|/metrics"'
LATENCY = f"sum by (route, le) (rate(ccdt_http_request_duration_seconds_bucket{{{COMPUTED}}}[]))"

# Title, panels per line, panels.
ROWS = [
    ("At a glance", 6, [
        number("Servers that answer", "Share of the servers that Prometheus knows.", "percentunit", {"": "avg(up)"},
               red_below=1, at_most=1),
        number("Requests", "Computed requests answered per second.", "reqps",
               {"": f"sum(rate(ccdt_http_requests_total{{{COMPUTED}}}[]))"}),
        number("Errors", "Share of answers with status 500 and above, without health checks and scrapes.",
               "percentunit",
               {"": f'(sum(rate(ccdt_http_requests_total{{status=~"5..", {NOT_PROBES}}}[])) or vector(0)) / '
                    f"sum(rate(ccdt_http_requests_total{{{NOT_PROBES}}}[]))"}, red_from=0.05, at_most=1),
        number("Queue", "How full the fullest queue is.", "percentunit",
               {"": "max(ccdt_queue_requests / ccdt_queue_capacity_requests)"}, red_from=0.8, at_most=1),
        number("Longest overdue", "Longest time that a worker has continued after a request to stop.", "s",
               {"": "max(ccdt_workers_overdue_seconds)"}, red_from=10),
        number("Up since", "Time since the last start of a server.", "s",
               {"": "time() - max(process_start_time_seconds)"}),
    ]),
    ("Requests", 3, [
        chart("Requests by route", "Requests answered per second, of any status.", "reqps",
              {"{{route}}": "sum by (route) (rate(ccdt_http_requests_total[]))"}),
        chart("Answers other than 200",
              "Answers per second by status. 429 means a full queue or a rate limit, 499 a client "
              "that disconnected.", "reqps",
              {"{{status}}": 'sum by (status) (rate(ccdt_http_requests_total{status!~"2.."}[]))'}),
        chart("Cancelled", "Cancelled computations and waits per second, by cause.", "reqps",
              {"{{cause}}": "sum by (cause) (rate(ccdt_cancellations_total[]))"}),
        chart("Latency, median", "From the first byte of the request to the last byte of the answer.", "s",
              {"{{route}}": f"histogram_quantile(0.5, {LATENCY})"}),
        chart("Latency, 99th percentile",
              "One request in a hundred takes longer. The dashed line is half of the default "
              "timeout.", "s", {"{{route}}": f"histogram_quantile(0.99, {LATENCY})"}, red_from=30),
        chart("Time by stage", "Mean time that a computed request spends in each stage, stacked.", "s",
              {"{{stage}}": "sum by (stage) (rate(ccdt_stage_duration_seconds_sum[])) / "
                            "sum by (stage) (rate(ccdt_stage_duration_seconds_count[]))"}, stacked=True),
        chart("Traffic", "Bytes of requests and answers per second, including heads.", "Bps",
              {"received": "sum(rate(ccdt_http_received_bytes_total[]))",
               "sent": "sum(rate(ccdt_http_sent_bytes_total[]))"}),
        chart("Sites", "Points placed per second.", "cps",
              {"{{instance}}": "sum by (instance) (rate(ccdt_sites_total[]))"}),
        chart("Pixels", "Pixels of decoded pictures per second.", "cps",
              {"{{instance}}": "sum by (instance) (rate(ccdt_pixels_total[]))"}),
    ]),
    ("Work", 3, [
        chart("Busy workers", "Share of all workers. At 100 % requests wait.", "percentunit",
              {"{{instance}}": "ccdt_workers_busy / ccdt_workers"}, at_most=1),
        chart("Waiting requests", "Requests in the queue, and its capacity.", "short",
              {"{{instance}}": "ccdt_queue_requests", "{{instance}}, capacity": "ccdt_queue_capacity_requests"}),
        chart("Waiting time",
              "Age of the oldest request in the queue, and time until all waiting requests will be done.",
              "s", {"{{instance}}, oldest": "ccdt_queue_oldest_seconds",
                    "{{instance}}, backlog": "ccdt_queue_backlog_seconds"}, red_from=30),
        chart("Overdue", "Longest time that a worker has continued after a request to stop.", "s",
              {"{{instance}}": "ccdt_workers_overdue_seconds"}, red_from=10),
        chart("Crashes",
              "Crashes of decoders and of computations, and restarts of the processes that start them, in five "
              "minutes.", "short",
              {"{{instance}}": "increase(ccdt_decoder_deaths_total[5m])",
               "{{instance}}, restarts of the decoder": "increase(ccdt_decoder_restarts_total[5m])",
               "{{instance}}, computations": "increase(ccdt_computation_crashes_total[5m])",
               "{{instance}}, computations that overran": "increase(ccdt_computations_overdue_total[5m])",
               "{{instance}}, restarts of the worker": "increase(ccdt_worker_restarts_total[5m])"}),
        chart("Memory of computations", "Memory reserved for computations, and the budget.", "bytes",
              {"{{instance}}": "ccdt_memory_reserved_bytes", "{{instance}}, budget": "ccdt_memory_budget_bytes"}),
        chart("Threads of a computation",
              "Threads that a computation may use now, and the mean over answers of the largest number "
              "used at once.", "short",
              {"{{instance}}, lent": "ccdt_computation_threads_lent",
               "{{instance}}, used": "rate(ccdt_computation_threads_sum[]) / rate(ccdt_computation_threads_count[])"}),
        chart("Cores that compute", "Mean number of cores. The time of a computation is counted when it ends.", "short",
              {"{{instance}}": "rate(ccdt_computation_cpu_seconds_total[])"}),
    ]),
    ("Jobs and cached answers", 4, [
        chart("Jobs",
              "Unfinished jobs: of all servers if they share jobs, otherwise of the server with the most.", "short",
              {"{{status}}": "max by (status) (ccdt_jobs)"}),
        chart("Ended jobs", "Finished jobs per minute, by final status.", "cpm",
              {"{{status}}": "60 * sum by (status) (rate(ccdt_jobs_ended_total[]))"}),
        chart("Stored bytes", "Bytes of jobs, their limit, and bytes of cached answers.", "bytes",
              {"{{instance}}, jobs": "ccdt_job_store_bytes",
               "{{instance}}, limit of jobs": "ccdt_job_store_capacity_bytes",
               "{{instance}}, cache": "ccdt_cache_bytes"}),
        chart("Cache hits", "Share of cache lookups that found an answer.", "percentunit",
              {"{{instance}}": "rate(ccdt_cache_hits_total[]) / "
                               "(rate(ccdt_cache_hits_total[]) + rate(ccdt_cache_misses_total[]))"}, at_most=1),
    ]),
    ("Servers that share a Redis", 4, [
        chart("Calls of Redis", "Calls per second, by purpose.", "ops",
              {"{{use}}": "sum by (use) (rate(ccdt_redis_calls_total[]))"}),
        chart("Time of a call", "Mean time of a call. It is long if Redis is slow or far away.", "s",
              {"{{use}}": "sum by (use) (rate(ccdt_redis_seconds_total[])) / "
                          "sum by (use) (rate(ccdt_redis_calls_total[]))"}),
        chart("Failed calls",
              "Share of all calls. Without Redis jobs wait, and each server counts and computes by itself.",
              "percentunit",
              {"{{instance}}, {{use}}": "sum by (instance, use) (rate(ccdt_redis_failures_total[])) / "
                                        "sum by (instance, use) (rate(ccdt_redis_calls_total[]))"}),
        chart("Lost leases and repeated runs",
              "In five minutes. Servers that are killed, stall or cannot reach Redis cause "
              "them.", "short",
              {"{{instance}}, leases": "increase(ccdt_job_leases_lost_total[5m])",
               "{{instance}}, runs": "increase(ccdt_job_runs_repeated_total[5m])"}),
        chart("Webhooks", "In five minutes. Hosts that are down or answer with errors cause failed attempts.", "short",
              {"{{instance}}, sent": "increase(ccdt_webhooks_sent_total[5m])",
               "{{instance}}, failed attempts": "increase(ccdt_webhook_failures_total[5m])"}),
    ]),
    ("Machine", 3, [
        chart("Resident memory", "Resident memory of the whole server.", "bytes",
              {"{{instance}}": "process_resident_memory_bytes"}),
        chart("Connections", "Open connections, and event streams among them.", "short",
              {"{{instance}}": "ccdt_connections_open", "{{instance}}, event streams": "ccdt_event_streams_open"}),
        chart("Refused connections",
              "In five minutes, by the limit that was reached: connections of the server (full), connections of an "
              "address, or event streams.", "short",
              {"{{reason}}": "sum by (reason) (increase(ccdt_connections_refused_total[5m]))"}),
        chart("Open files", "Share of the limit on open files. Each connection is an open file.", "percentunit",
              {"{{instance}}": "process_open_fds / process_max_fds"}, red_from=0.8, at_most=1),
        chart("Starts", "Changes of the start time within an hour.", "short",
              {"{{instance}}": "changes(process_start_time_seconds[1h])"}, red_from=3),
        chart("Versions", "Number of servers of each version.", "short",
              {"{{version}}": "count by (version) (ccdt_build_info)"}, stacked=True),
    ]),
]


def placed(rows):
    """Yields the panels of all rows, with their positions below the row's title."""
    numbers = iter(range(1, 1000))
    y = 0
    for title, columns, panels in rows:
        yield {"id": next(numbers), "type": "row", "title": title, "collapsed": False, "panels": [],
               "gridPos": {"x": 0, "y": y, "w": WIDTH, "h": 1}}
        y += 1
        height = 4 if panels[0]["type"] == "stat" else 8
        for i in range(0, len(panels), columns):
            line = panels[i:i + columns]
            width = WIDTH // len(line)
            for column, each in enumerate(line):
                yield {"id": next(numbers), **each,
                       "gridPos": {"x": column * width, "y": y, "w": width, "h": height}}
            y += height


def variables():
    """Returns the variables at the top of the dashboard: the data source and the servers."""
    return [
        {"name": "datasource", "label": "Data source", "type": "datasource", "query": "prometheus"},
        {"name": "instance", "label": "Server", "type": "query", "datasource": SOURCE, "refresh": 2, "sort": 1,
         "includeAll": True, "multi": True, "current": {"text": ["All"], "value": ["$__all"]},
         "query": {"query": 'label_values(ccdt_build_info{job="ccdt"}, instance)', "refId": "instances"}},
    ]


def dashboard():
    return {"uid": "ccdt-server", "title": "ccdt-server", "tags": ["ccdt"],
            "description": "Requests, work and machine of the servers that the job `ccdt` scrapes.",
            "schemaVersion": 38, "editable": True, "graphTooltip": 1, "refresh": "30s",
            "time": {"from": "now-3h", "to": "now"}, "templating": {"list": variables()},
            "panels": list(placed(ROWS))}


if __name__ == "__main__":
    print(json.dumps(dashboard(), indent=2))
